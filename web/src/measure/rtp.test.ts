import { expect, it } from "vitest";
import { RtpTimeline } from "./rtp";

function timeline(rtp_origin: number, rate_hz = 90_000): RtpTimeline {
  const made = new RtpTimeline();
  made.set({ type: "rtp_clock", kind: "video", rtp_origin, rate_hz, origin_server_ms: 5000 });
  return made;
}

it("knows nothing without the server's mapping or a timestamp", () => {
  expect(new RtpTimeline().capturedMs(1)).toBeNull();
  expect(timeline(0).capturedMs(undefined)).toBeNull();
});

it("counts forward and back from the origin", () => {
  expect(timeline(1000).capturedMs(1000)).toBe(5000);
  expect(timeline(1000).capturedMs(1000 + 90_000)).toBe(6000);
  expect(timeline(90_000).capturedMs(0)).toBe(4000);
  expect(timeline(0, 48_000).capturedMs(960)).toBe(5020);
});

it("counts across the wrap at 2³² in both directions", () => {
  expect(timeline(2 ** 32 - 45_000).capturedMs(45_000)).toBe(6000);
  expect(timeline(45_000).capturedMs(2 ** 32 - 45_000)).toBe(4000);
});

it("forgets the previous peer's mapping", () => {
  const made = timeline(0);
  made.set(null);
  expect(made.capturedMs(0)).toBeNull();
});
