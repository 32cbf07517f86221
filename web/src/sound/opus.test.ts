import { expect, it } from "vitest";
import { opusTicks } from "./opus";

// RFC 6716, 3.1: configuration, stereo, and how many frames.
const toc = (config: number, code: number) => (config << 3) | code;

it.each([
  [[toc(0, 0), 1], 480], // SILK, 10 ms
  [[toc(3, 0), 1], 2880], // SILK, 60 ms
  [[toc(13, 0), 1], 960], // hybrid, 20 ms
  [[toc(16, 0), 1], 120], // CELT, 2.5 ms
  [[toc(31, 0), 1], 960], // CELT, 20 ms
  [[toc(31, 1), 1], 1920], // two frames of the same size
  [[toc(30, 2), 1], 960], // two frames of different sizes
  [[toc(31, 3), 6], 5760], // six frames: 120 ms, the longest
  [[toc(31, 3), 7], 0], // longer than Opus allows
  [[toc(31, 3)], 0], // without its count
  [[], 0],
])("a packet that begins with %j holds %i samples", (bytes, ticks) => {
  expect(opusTicks(Uint8Array.from(bytes))).toBe(ticks);
});
