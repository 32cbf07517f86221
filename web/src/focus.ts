const CLICKED = "button, summary, input[type=radio]";
/** A click only opens the list of a select; losing the focus would close it. */
const CHANGED = "select, input[type=range], input[type=radio]";

/**
 * Returns the keyboard to driving after a pointer used a control. Otherwise the arrow keys would
 * change the radio button clicked last, and Space would toggle the sound instead of stopping the
 * robot. Keyboard users keep the focus.
 */
export function returnFocusAfterPointer(document: Document, signal: AbortSignal): void {
  let byPointer = false;
  const note = (event: Event) => {
    byPointer = event.type === "pointerdown";
  };
  const giveBack = (event: Event) => {
    const controls = event.type === "click" ? CLICKED : CHANGED;
    const control = event.target instanceof Element && event.target.closest(controls);
    if (byPointer && control instanceof HTMLElement) control.blur();
  };
  const capture = { capture: true, signal };
  document.addEventListener("pointerdown", note, capture);
  document.addEventListener("keydown", note, capture);
  // After the control's own listeners.
  document.addEventListener("click", giveBack, { signal });
  document.addEventListener("change", giveBack, { signal });
}
