import { codeOf } from "../drive/codeOf";
import { fingerHolder } from "../drive/inputState";
import { holderOf, KeysDown } from "../drive/keysDown";
import { listenLetGo } from "../drive/letGo";
import { isOwnPress } from "../typing";
import type { Talk } from "./talk";

/**
 * Speaks while the key for it is held, unless a text field has the focus; falls silent as soon as
 * the page can no longer know that something is held.
 */
export function listenTalk(
  window: Window,
  talk: Pick<Talk, "press" | "release" | "letGo">,
  isKey: (code: string, isShifted: boolean) => boolean,
  signal: AbortSignal,
): void {
  const down = new KeysDown((holder) => void talk.release(holder));
  const onDown = (event: KeyboardEvent) => {
    down.press(event);
    const isTalk = isKey(codeOf(event), event.shiftKey);
    if (isTalk && isOwnPress(event)) talk.press(holderOf(event));
  };
  const onUp = (event: KeyboardEvent) => down.lift(event);
  window.addEventListener("keydown", onDown, { signal });
  window.addEventListener("keyup", onUp, { signal });
  window.addEventListener("blur", () => down.clear(), { signal });
  listenLetGo(window, {
    letGo: () => talk.letGo(),
    lift: (pointerId) => talk.release(fingerHolder(pointerId)),
    signal,
  });
}
