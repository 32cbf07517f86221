/** Picture in picture, by the standard API and by Safari's. */

interface SafariVideo {
  webkitSupportsPresentationMode?: (mode: string) => boolean;
  webkitSetPresentationMode?: (mode: string) => void;
  webkitPresentationMode?: string;
}

type Video = HTMLVideoElement & SafariVideo;

/** Not a type guard: a video without the standard API may still have Safari's. */
function isStandard(video: object): boolean {
  return "requestPictureInPicture" in video;
}

/** Whether a page can start picture in picture here; Firefox has its own button instead. */
export function canLeavePage(scope: typeof globalThis = globalThis): boolean {
  const video: Partial<Video> = scope.HTMLVideoElement?.prototype ?? {};
  if (isStandard(video)) return scope.document.pictureInPictureEnabled ?? false;
  return typeof video.webkitSetPresentationMode === "function";
}

export function isApart(video: Video): boolean {
  if (video.webkitPresentationMode !== undefined && !isStandard(video)) {
    return video.webkitPresentationMode === "picture-in-picture";
  }
  return video.ownerDocument.pictureInPictureElement === video;
}

/** Rejects where the browser refuses, as before the first picture. */
export async function leavePage(video: Video): Promise<void> {
  if (isStandard(video)) await video.requestPictureInPicture?.();
  else if (video.webkitSupportsPresentationMode?.("picture-in-picture")) {
    video.webkitSetPresentationMode?.("picture-in-picture");
  } else throw new Error("not supported");
}

export async function comeBack(video: Video): Promise<void> {
  if (!isApart(video)) return;
  if (isStandard(video)) await video.ownerDocument.exitPictureInPicture?.();
  else video.webkitSetPresentationMode?.("inline");
}

/** Calls `changed` when the video leaves the page or returns; returns what stops watching. */
export function watchApart(video: Video, changed: () => void): () => void {
  const watching = new AbortController();
  const { signal } = watching;
  for (const event of [
    "enterpictureinpicture",
    "leavepictureinpicture",
    "webkitpresentationmodechanged",
  ]) {
    video.addEventListener(event, changed, { signal });
  }
  return () => watching.abort();
}
