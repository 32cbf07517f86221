import { expect, it } from "vitest";
import { RtpTimeline } from "./rtp";
import { SoundMeter } from "./sound";

const ORIGIN = 1.7e12;

function meter(): SoundMeter {
  const timeline = new RtpTimeline();
  timeline.set({
    type: "rtp_clock",
    kind: "audio",
    rtp_origin: 0,
    rate_hz: 48_000,
    origin_server_ms: 10_000,
  });
  return new SoundMeter(timeline, (pageMs) => pageMs + 10_000, ORIGIN);
}

function source(timestamp: number, rtpTimestamp: number): RTCRtpSynchronizationSource {
  return { source: 1, timestamp, rtpTimestamp };
}

it("measures from capture to playing, whichever epoch the browser uses", () => {
  for (const base of [ORIGIN, 0]) {
    const made = meter();
    made.sample(source(base + 1070, 48_000), 1075);
    expect(made.flush()).toBeCloseTo(70);
  }
});

it("takes the median, so that one stall between two calls does not show", () => {
  const made = meter();
  for (const [atMs, rtp] of [
    [1070, 48_000],
    [1172, 52_800],
    [1900, 57_600],
  ] as const) {
    made.sample(source(ORIGIN + atMs, rtp), atMs);
  }
  expect(made.flush()).toBeCloseTo(72);
  expect(made.flush()).toBeNull();
});

it("measures nothing without data, or with old data", () => {
  const made = meter();
  made.sample(undefined, 1000);
  made.sample(source(ORIGIN + 1000, 48_000), 9000);
  expect(made.flush()).toBeNull();
});
