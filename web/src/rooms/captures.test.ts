import { expect, it } from "vitest";
import { RtpTimeline } from "../measure/rtp";
import { CaptureClock, rtpClock } from "./captures";

const NTP_MS = 2_208_988_800_000;

it("maps RTP time by the newest packet's capture time", () => {
  const timeline = new RtpTimeline();
  const source = { source: 1, timestamp: 0, rtpTimestamp: 90_000, captureTimestamp: NTP_MS + 5000 };
  timeline.set(rtpClock("video", source));
  expect(timeline.capturedMs(93_600)).toBe(5040);
  timeline.set(rtpClock("audio", source));
  expect(timeline.capturedMs(91_920)).toBe(5040);
});

it("knows nothing without one", () => {
  expect(rtpClock("video", undefined)).toBeNull();
  expect(rtpClock("video", { source: 1, timestamp: 0, rtpTimestamp: 1 })).toBeNull();
});

it("compares ages whatever the clocks' offset", () => {
  const clock = new CaptureClock();
  expect(clock.toServerMs(0)).toBeNull();
  clock.add(1_700_000_000_000, 10_000);
  clock.add(1_700_000_000_090, 10_050);
  const age = (capturedMs: number, atMs: number) => (clock.toServerMs(atMs) ?? 0) - capturedMs;
  const picture = age(1_700_000_001_000, 11_100);
  const sound = age(1_700_000_001_000, 11_160);
  expect(sound - picture).toBe(60);
  expect(picture).toBeGreaterThanOrEqual(0);
  expect(clock.errorMs()).toBeNull();
});
