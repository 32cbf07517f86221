import type { Cameras } from "./cameras";

/** By position, not by letter. */
const KEY = "KeyC";
const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

/** Makes the next camera large when C is pressed, unless a text field has the focus. */
export function listenCameras(
  window: Window,
  cameras: Pick<Cameras, "next">,
  signal: AbortSignal,
): void {
  const onDown = (event: KeyboardEvent) => {
    const focus = event.target instanceof Element ? event.target : null;
    const isOther = event.ctrlKey || event.metaKey || event.altKey;
    if (event.code !== KEY || event.repeat || isOther || focus?.closest(TYPING)) return;
    cameras.next();
  };
  window.addEventListener("keydown", onDown, { signal });
}
