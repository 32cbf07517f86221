import { codeOf } from "./drive/codeOf";
import { isOwnPress } from "./typing";

/** Calls `act` on each press of a key for it, unless a text field has the focus. */
export function listenKey(
  window: Window,
  act: () => void,
  isKey: (code: string, isShifted: boolean) => boolean,
  signal: AbortSignal,
): void {
  const onDown = (event: KeyboardEvent) => {
    if (isKey(codeOf(event), event.shiftKey) && isOwnPress(event)) act();
  };
  window.addEventListener("keydown", onDown, { signal });
}
