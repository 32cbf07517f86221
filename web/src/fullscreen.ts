/** The page in fullscreen, by the standard API and by older WebKit's. */

interface WebKitDocument {
  webkitFullscreenEnabled?: boolean;
  webkitFullscreenElement?: Element | null;
  webkitExitFullscreen?: () => void;
}

interface WebKitElement {
  webkitRequestFullscreen?: () => void;
}

/** An iPhone shows only a video in fullscreen, under its own controls: no way to stop the robot. */
interface IPhoneVideo {
  webkitEnterFullscreen?: () => void;
}

type Page = Document & WebKitDocument;

/** Whether the page itself can be in fullscreen here. */
export function hasFullscreen(page: Page = document): boolean {
  return page.fullscreenEnabled ?? page.webkitFullscreenEnabled ?? false;
}

export function isFullscreen(page: Page = document): boolean {
  return (page.fullscreenElement ?? page.webkitFullscreenElement ?? null) !== null;
}

/** Rejects where the browser refuses. Call it during a touch. */
export async function enterFullscreen(page: Page = document): Promise<void> {
  const root: HTMLElement & WebKitElement = page.documentElement;
  if (typeof root.requestFullscreen === "function") {
    await root.requestFullscreen({ navigationUI: "hide" });
  } else if (root.webkitRequestFullscreen) root.webkitRequestFullscreen();
  else throw new Error("not supported");
}

export async function leaveFullscreen(page: Page = document): Promise<void> {
  if (typeof page.exitFullscreen === "function") await page.exitFullscreen();
  else page.webkitExitFullscreen?.();
}

/** Whether at least the video can go fullscreen, as on an iPhone; for viewers who do not drive. */
export function hasVideoFullscreen(video: (HTMLVideoElement & IPhoneVideo) | null): boolean {
  return typeof video?.webkitEnterFullscreen === "function";
}

export function enterVideoFullscreen(video: HTMLVideoElement & IPhoneVideo): void {
  video.webkitEnterFullscreen?.();
}

/** Calls `changed` when fullscreen begins or ends; returns a function that stops watching. */
export function watchFullscreen(changed: () => void, page: Page = document): () => void {
  const watching = new AbortController();
  const { signal } = watching;
  page.addEventListener("fullscreenchange", changed, { signal });
  page.addEventListener("webkitfullscreenchange", changed, { signal });
  return () => watching.abort();
}
