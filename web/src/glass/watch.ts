/** Reads the time code in the pictures that an element presents. */

import type { Session } from "../actions";
import { ageOf, type Sight } from "./delays";
import type { Grey } from "./finders";
import { type Miss, read } from "./read";
import { serverMsAt } from "./serverTime";

export type Problem = Exclude<Miss, "between"> | "late" | "other_time";

/** Larger pictures are made smaller: a module of the code needs three pixels. */
const MOST_WIDTH = 640;
/** So many late pictures in a row are worth a hint; any browser has one now and then. */
const LATE_IN_A_ROW = 10;

/** A picture, and what the browser said of it. Times are on the page's clock, one on the server's. */
interface Held {
  picture: Grey;
  frames: number;
  presentedMs: number;
  drawnMs: number;
  capturedServerMs: number | null;
}

/**
 * Calls `told` with what every other picture shows, or why it shows nothing; returns what ends this,
 * or null where the browser does not say when it presents a picture. `session` shows its picture
 * there already, so that it knows of each before this does.
 */
export function watchCode(
  video: HTMLVideoElement,
  { state, seenServerMs }: Pick<Session, "state" | "seenServerMs">,
  told: (what: Sight | Problem) => void,
): (() => void) | null {
  const request = video.requestVideoFrameCallback?.bind(video);
  const context = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  if (!request || !context) return null;
  let held: Held | null = null;
  let late = 0;
  let handle = 0;
  const onFrame: VideoFrameRequestCallback = (nowMs, frame) => {
    handle = request(onFrame);
    const presentedMs = frame.presentationTime || nowMs;
    if (held) {
      // What was drawn is the next picture if that was there by then.
      const isSame = frame.presentedFrames === held.frames + 1 && presentedMs > held.drawnMs;
      late = isSame ? 0 : late + 1;
      const what = isSame ? shown(held) : "late";
      held = null;
      const isPassing = what === "between" || (what === "late" && late < LATE_IN_A_ROW);
      if (!isPassing) told(what);
    } else if (video.videoWidth > 0) {
      const drawnMs = draw(video, context);
      const seen = { frames: frame.presentedFrames, presentedMs, drawnMs };
      held = { ...seen, picture: greyOf(context), capturedServerMs: seenServerMs() };
    }
  };
  const shown = ({ picture, presentedMs, capturedServerMs }: Held) => {
    const serverMs = serverMsAt(state, presentedMs);
    const seen = read(picture);
    if ("miss" in seen) return seen.miss;
    const totalMs = serverMs === null ? null : ageOf(seen.ms, serverMs);
    if (totalMs === null || serverMs === null) return "other_time";
    return { totalMs, knownMs: capturedServerMs === null ? null : serverMs - capturedServerMs };
  };
  handle = request(onFrame);
  return () => video.cancelVideoFrameCallback?.(handle);
}

/** Draws what the element shows now; returns when that was done. */
function draw(video: HTMLVideoElement, context: CanvasRenderingContext2D): number {
  const { canvas } = context;
  const scale = Math.min(1, MOST_WIDTH / video.videoWidth);
  const width = Math.round(video.videoWidth * scale);
  const height = Math.round(video.videoHeight * scale);
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  context.drawImage(video, 0, 0, width, height);
  return performance.now();
}

function greyOf(context: CanvasRenderingContext2D): Grey {
  const { width, height } = context.canvas;
  const { data: rgba } = context.getImageData(0, 0, width, height);
  const data = new Uint8Array(width * height);
  for (let at = 0; at < data.length; at++) {
    const [red = 0, green = 0, blue = 0] = [rgba[4 * at], rgba[4 * at + 1], rgba[4 * at + 2]];
    data[at] = (77 * red + 150 * green + 29 * blue) >> 8;
  }
  return { width, height, data };
}
