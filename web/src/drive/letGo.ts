/** What is let go of by itself. */
export interface LetGoOptions {
  /** Lets go of everything at once. */
  letGo: () => void;
  /** Releases what this finger holds; false where it held nothing. */
  lift: (pointerId: number) => boolean;
  signal: AbortSignal;
}

/**
 * The moments at which nobody can be trusted to hold the controls any more: the window loses the
 * keyboard, the page is hidden, frozen or left, a menu opens over it, the system takes a finger
 * away. A finger that is lifted counts wherever it is, should its own button not hear of it.
 */
export function listenLetGo(window: Window, { letGo, lift, signal }: LetGoOptions): void {
  const { document } = window;
  const options = { signal };
  for (const type of ["blur", "pagehide", "beforeunload", "contextmenu"]) {
    window.addEventListener(type, letGo, options);
  }
  document.addEventListener("freeze", letGo, options);
  const onVisibility = () => {
    if (document.visibilityState === "hidden" || document.hidden) letGo();
  };
  document.addEventListener("visibilitychange", onVisibility, options);
  window.addEventListener("pointerup", (event) => void lift(event.pointerId), options);
  const onCancel = (event: PointerEvent) => {
    if (lift(event.pointerId)) letGo();
  };
  window.addEventListener("pointercancel", onCancel, options);
}
