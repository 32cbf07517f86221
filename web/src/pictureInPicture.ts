/** A picture in a window of its own: as the standard has it, and as Safari has it. */

interface SafariVideo {
  webkitSupportsPresentationMode?: (mode: string) => boolean;
  webkitSetPresentationMode?: (mode: string) => void;
  webkitPresentationMode?: string;
}

type Video = HTMLVideoElement & SafariVideo;

/** Not a type guard: what lacks the standard's may still have Safari's. */
function isStandard(video: object): boolean {
  return "requestPictureInPicture" in video;
}

/** Whether a page can do it here; Firefox has a button of its own instead. */
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

/** Calls `changed` when it leaves the page or returns; returns a function that ends it. */
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
