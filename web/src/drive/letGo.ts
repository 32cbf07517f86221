/** What to do when input ends without a release. */
export interface LetGoOptions {
  /** Releases everything at once. */
  letGo: () => void;
  /**
   * Releases what this finger holds, and what it began if the system has cancelled the touch;
   * returns false if that is nothing.
   */
  lift: (pointerId: number, isCancelled: boolean) => boolean;
  signal: AbortSignal;
}

/**
 * Releases the controls when the page can no longer know that they are held: the window loses the
 * focus, the page is hidden, frozen or left, a menu opens over it, or the system cancels a touch. A
 * lifted finger counts anywhere, in case its own button does not get the event.
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
  window.addEventListener("pointerup", (event) => void lift(event.pointerId, false), options);
  const onCancel = (event: PointerEvent) => {
    if (lift(event.pointerId, true)) letGo();
  };
  window.addEventListener("pointercancel", onCancel, options);
}
