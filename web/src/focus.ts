/** Where the keyboard's focus goes on the page; what its loss does to driving: `drive/letGo.ts`. */

const CLICKED = "button, summary, input[type=radio]";
/** A click only opens the list of a select; losing the focus would close it. */
const CHANGED = "select, input[type=range], input[type=radio]";

/**
 * Returns the keyboard to driving after a pointer used a control. Otherwise the arrow keys would
 * change the slider touched last, and Space would toggle the sound instead of stopping the
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

/** Where the keyboard may land: nothing that Space or Enter would press. */
const LANDING = "section, fieldset, form, main";

/**
 * When a focused element is removed, keeps the focus near its place; otherwise a screen reader, and
 * Tab in some browsers, would start again at the top of the page.
 */
export function keepFocus(document: Document, signal: AbortSignal): void {
  /** The focused element and its ancestors. */
  let way: Element[] = [];
  let byPointer = false;
  const note = (event: Event) => {
    way = [];
    let at = !byPointer && event.target instanceof Element ? event.target : null;
    for (; at; at = at.parentElement) way.push(at);
  };
  const pointed = () => {
    byPointer = true;
    way = [];
  };
  const typed = () => {
    byPointer = false;
  };
  const gone = new MutationObserver(() => {
    const [had, ...around] = way;
    if (!had || had.isConnected) return;
    way = [];
    if (document.activeElement && document.activeElement !== document.body) return;
    const place = around
      .filter((one) => one.isConnected)
      .map((one) => (one.matches(LANDING) ? one : one.querySelector(LANDING)))
      .find((one) => one !== null);
    if (place instanceof HTMLElement) land(place);
  });
  gone.observe(document, { childList: true, subtree: true });
  const capture = { capture: true, signal };
  document.addEventListener("focusin", note, capture);
  document.addEventListener("pointerdown", pointed, capture);
  document.addEventListener("keydown", typed, capture);
  signal.addEventListener("abort", () => gone.disconnect());
}

function land(place: HTMLElement): void {
  place.tabIndex = -1;
  // Otherwise a later click in it would focus it.
  place.addEventListener("blur", () => place.removeAttribute("tabindex"), { once: true });
  place.focus({ preventScroll: true });
}
