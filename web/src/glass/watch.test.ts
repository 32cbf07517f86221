// @vitest-environment dom
import { beforeEach, expect, it, vi } from "vitest";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { HEIGHT, MARGIN, patches, WIDTH } from "./code";
import type { Sight } from "./delays";
import { type Problem, watchCode } from "./watch";

const SCALE = 8;
const SIZE = { width: (WIDTH + 2 * MARGIN) * SCALE, height: (HEIGHT + 2 * MARGIN) * SCALE };
/** The server's clock is this far ahead of the page's. */
const AHEAD_MS = 5000;

let nowMs: number;
let filmedMs: number;
let capturedServerMs: number | null;
let onFrame: VideoFrameRequestCallback;
let state: State;
let seen: (Sight | Problem)[];

/** The pixels of a picture that shows the code of this time. */
function pixels(ms: number): Uint8ClampedArray {
  const { width, height } = SIZE;
  const rgba = new Uint8ClampedArray(4 * width * height).fill(255);
  for (const { box, isWhite } of patches(ms)) {
    const [left = 0, top = 0, across = 0, down = 0] = box.map((one) => Math.round(one * SCALE));
    for (let y = top + MARGIN * SCALE; y < top + MARGIN * SCALE + down; y++) {
      const from = y * width + left + MARGIN * SCALE;
      rgba.fill(isWhite ? 255 : 0, 4 * from, 4 * (from + across));
    }
  }
  return rgba;
}

beforeEach(() => {
  [nowMs, filmedMs, capturedServerMs, seen] = [0, 0, null, []];
  state = createState(loadPreferences(null));
  state.serverMs.value = AHEAD_MS;
  state.pageMs.value = 0;
  vi.spyOn(performance, "now").mockImplementation(() => nowMs);
  const context = {
    canvas: { ...SIZE },
    drawImage: () => {
      nowMs += 4;
    },
    getImageData: () => ({ data: pixels(filmedMs) }),
  };
  vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(context as never);
  const video = {
    videoWidth: SIZE.width,
    videoHeight: SIZE.height,
    requestVideoFrameCallback: (called: VideoFrameRequestCallback) => {
      onFrame = called;
      return 1;
    },
  } as Partial<HTMLVideoElement> as HTMLVideoElement;
  const session = { state, seenServerMs: () => capturedServerMs };
  watchCode(video, session, (what) => seen.push(what));
});

/** Presents a picture at a time, whose callback comes `afterMs` later. */
function present(presentedFrames: number, presentationTime: number, afterMs = 2): void {
  nowMs = presentationTime + afterMs;
  onFrame(nowMs, { presentedFrames, presentationTime } as VideoFrameCallbackMetadata);
}

it("tells the delay of a picture, and the part of it that is known", () => {
  filmedMs = AHEAD_MS + 1000 - 150;
  capturedServerMs = AHEAD_MS + 1000 - 90;
  present(1, 1000);
  expect(seen).toEqual([]);
  present(2, 1033);
  expect(seen).toEqual([{ totalMs: expect.closeTo(150, 0), knownMs: 90 }]);
  capturedServerMs = null;
  present(3, 1066);
  present(4, 1100);
  expect(seen[1]).toEqual({ totalMs: expect.closeTo(216, 0), knownMs: null });
});

it("drops a picture that another may have replaced before it was drawn", () => {
  filmedMs = AHEAD_MS + 900;
  present(1, 1000, 40);
  present(2, 1033, 12);
  present(3, 1066);
  present(5, 1133);
  expect(seen).toEqual([]);
});

it("says that pictures are late once ten in a row are", () => {
  filmedMs = AHEAD_MS + 900;
  for (let frames = 1; frames < 58; frames += 3) present(frames, 1000 + 33 * frames);
  expect(seen).toEqual([]);
  present(58, 3000);
  expect(seen).toEqual(["late"]);
});

it("says why a picture shows no time of now", () => {
  filmedMs = AHEAD_MS - 20_000;
  present(1, 1000);
  present(2, 1033);
  expect(seen).toEqual(["other_time"]);
  vi.mocked(HTMLCanvasElement.prototype.getContext).mockRestore();
  expect(watchCode({} as HTMLVideoElement, { state, seenServerMs: () => 0 }, () => {})).toBeNull();
});

it("waits for the next picture while the code changes", () => {
  filmedMs = AHEAD_MS + 896 - 4;
  filmedMs -= filmedMs % 256;
  present(1, 1000);
  present(2, 1033);
  expect(seen).toEqual([]);
});
