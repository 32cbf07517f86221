import type { Cameras } from "./cameras";

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

/** Makes the next camera large by the key for it, unless a text field has the focus. */
export function listenCameras(
  window: Window,
  cameras: Pick<Cameras, "next">,
  isKey: (code: string) => boolean,
  signal: AbortSignal,
): void {
  const onDown = (event: KeyboardEvent) => {
    const focus = event.target instanceof Element ? event.target : null;
    const isOther = event.ctrlKey || event.metaKey || event.altKey;
    if (!isKey(event.code) || event.repeat || isOther || focus?.closest(TYPING)) return;
    cameras.next();
  };
  window.addEventListener("keydown", onDown, { signal });
}
