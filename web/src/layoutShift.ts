const CONTROLS = "button, summary, a[href]";
/** Who went farther meant something else, such as not to press after all. */
const SAME_PLACE_PX = 10;

/**
 * Gives a click to the control that was pressed, where the page moved under a pointer that did not:
 * people come and go in the lists above. A browser gives it to what holds both ends (UI Events,
 * `click`), where it does nothing.
 */
export function clickDespiteShift(document: Document, signal: AbortSignal): void {
  let pressed: { control: HTMLElement; x: number; y: number } | null = null;
  const press = ({ target, clientX, clientY }: PointerEvent) => {
    const control = target instanceof Element ? target.closest<HTMLElement>(CONTROLS) : null;
    pressed = control && { control, x: clientX, y: clientY };
  };
  const click = ({ target, clientX, clientY, detail }: MouseEvent) => {
    const meant = pressed;
    pressed = null;
    if (!meant || !(target instanceof Element) || target.closest(CONTROLS) === meant.control)
      return;
    const { control, x, y } = meant;
    const isThere = Math.hypot(clientX - x, clientY - y) <= SAME_PLACE_PX;
    if (!isThere || !target.contains(control)) return;
    // Not `control.click()`, which looks like a click without a pointer.
    const init = { bubbles: true, cancelable: true, clientX, clientY, detail };
    control.dispatchEvent(new MouseEvent("click", init));
  };
  document.addEventListener("pointerdown", press, { capture: true, signal });
  document.addEventListener("click", click, { capture: true, signal });
}
