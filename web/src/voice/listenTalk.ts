import { fingerHolder } from "../drive/inputState";
import { listenLetGo } from "../drive/letGo";
import { isOwnPress } from "../typing";
import type { Talk } from "./talk";

/**
 * Speaks while the key for it is held, unless a text field has the focus, and falls silent wherever the page
 * cannot know any more that something is held.
 */
export function listenTalk(
  window: Window,
  talk: Pick<Talk, "press" | "release" | "letGo">,
  isKey: (code: string) => boolean,
  signal: AbortSignal,
): void {
  const onDown = (event: KeyboardEvent) => {
    if (isKey(event.code) && isOwnPress(event)) talk.press(`key ${event.code}`);
  };
  const onUp = (event: KeyboardEvent) => {
    talk.release(`key ${event.code}`);
  };
  window.addEventListener("keydown", onDown, { signal });
  window.addEventListener("keyup", onUp, { signal });
  listenLetGo(window, {
    letGo: () => talk.letGo(),
    lift: (pointerId) => talk.release(fingerHolder(pointerId)),
    signal,
  });
}
