/**
 * The moments at which nobody can be trusted to hold the controls any more: the window loses the
 * keyboard, the page is hidden or left, a menu opens over it.
 */
export function listenRelease(window: Window, letGo: () => void, signal: AbortSignal): void {
  const { document } = window;
  const options = { signal };
  window.addEventListener("blur", letGo, options);
  window.addEventListener("pagehide", letGo, options);
  window.addEventListener("contextmenu", letGo, options);
  document.addEventListener("freeze", letGo, options);
  const onVisibility = () => {
    if (document.visibilityState === "hidden" || document.hidden) letGo();
  };
  document.addEventListener("visibilitychange", onVisibility, options);
}
