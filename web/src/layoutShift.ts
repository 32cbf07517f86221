const CONTROLS = "button, summary, a[href]";
/** A pointer that moved farther meant something else, such as cancelling the press. */
const SAME_PLACE_PX = 10;

/**
 * Delivers a click to the control that was pressed, although the page moved under a still pointer
 * because the lists above grew or shrank. A browser delivers it to the nearest common ancestor of
 * press and release (UI Events, `click`), where it does nothing, or to what is under the finger.
 */
export function clickDespiteShift(document: Document, signal: AbortSignal): void {
  let pressed: { control: Element; x: number; y: number } | null = null;
  const press = ({ target, clientX, clientY }: PointerEvent) => {
    const control = target instanceof Element ? target.closest(CONTROLS) : null;
    pressed = control && { control, x: clientX, y: clientY };
  };
  const click = (event: MouseEvent) => {
    const meant = pressed;
    pressed = null;
    // A click by keyboard has no position.
    if (!meant || event.detail === 0) return;
    const { control, x, y } = meant;
    const isSamePlace = Math.hypot(event.clientX - x, event.clientY - y) <= SAME_PLACE_PX;
    const isThere = control.contains(document.elementFromPoint(x, y));
    if (!isSamePlace || isThere || !control.isConnected || control.matches(":disabled")) return;
    if (event.target instanceof Node && control.contains(event.target)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    // Not `control.click()`, which looks like a click by keyboard.
    control.dispatchEvent(new MouseEvent("click", event));
  };
  document.addEventListener("pointerdown", press, { capture: true, signal });
  document.addEventListener("click", click, { capture: true, signal });
}
