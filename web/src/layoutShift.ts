const CONTROLS = "button, summary, a[href]";
/** Who went farther meant something else, such as not to press after all. */
const SAME_PLACE_PX = 10;

/**
 * Gives a click to the control that was pressed, where the page moved under a pointer that did not:
 * people come and go in the lists above. A browser gives it to what both ends have in common (UI
 * Events, `click`), where it does nothing, or to what a finger is over when it leaves.
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
    // A keyboard's has no place.
    if (!meant || event.detail === 0) return;
    const { control, x, y } = meant;
    const isSamePlace = Math.hypot(event.clientX - x, event.clientY - y) <= SAME_PLACE_PX;
    const isThere = control.contains(document.elementFromPoint(x, y));
    if (!isSamePlace || isThere || !control.isConnected || control.matches(":disabled")) return;
    if (event.target instanceof Node && control.contains(event.target)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    // Not `control.click()`, which looks like a click without a pointer.
    control.dispatchEvent(new MouseEvent("click", event));
  };
  document.addEventListener("pointerdown", press, { capture: true, signal });
  document.addEventListener("click", click, { capture: true, signal });
}
