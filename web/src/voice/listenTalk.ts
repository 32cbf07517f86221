import { fingerHolder } from "../drive/inputState";
import { listenLetGo } from "../drive/letGo";
import type { Talk } from "./talk";

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

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
    const focus = event.target instanceof Element ? event.target : null;
    const isOther = event.ctrlKey || event.metaKey || event.altKey;
    if (!isKey(event.code) || event.repeat || isOther || focus?.closest(TYPING)) return;
    talk.press(`key ${event.code}`);
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
