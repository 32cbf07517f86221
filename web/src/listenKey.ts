const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

/** Does `act` at each press of a key for it, unless a text field has the focus. */
export function listenKey(
  window: Window,
  act: () => void,
  isKey: (code: string) => boolean,
  signal: AbortSignal,
): void {
  const onDown = (event: KeyboardEvent) => {
    const focus = event.target instanceof Element ? event.target : null;
    const isOther = event.ctrlKey || event.metaKey || event.altKey;
    if (!isKey(event.code) || event.repeat || isOther || focus?.closest(TYPING)) return;
    act();
  };
  window.addEventListener("keydown", onDown, { signal });
}
