import { beforeEach, expect, it } from "vitest";
import { PictureMeter } from "./picture";
import { RtpTimeline } from "./rtp";

const timeline = new RtpTimeline();
let meter: PictureMeter;

beforeEach(() => {
  timeline.set({
    type: "rtp_clock",
    kind: "video",
    rtp_origin: 0,
    rate_hz: 90_000,
    origin_server_ms: 10_000,
  });
  meter = new PictureMeter(timeline, (pageMs) => pageMs + 10_000);
});

it("measures from capture to presentation", () => {
  meter.presented(0, 40);
  meter.presented(9000, 160);
  expect(meter.take(200)).toEqual({ ageMs: 50, rateHz: 2 });
  expect(meter.newestServerMs).toBe(10_100);
});

it("tells the age of a picture that stands still, but not of one that is merely awaited", () => {
  meter.presented(0, 40);
  meter.take(50);
  expect(meter.take(300).ageMs).toBeNull();
  expect(meter.take(2000).ageMs).toBe(2000);
});

it("counts the frames of the last second, also where the browser tells no RTP time", () => {
  for (let at = 0; at < 2000; at += 50) meter.presented(undefined, at);
  expect(meter.take(2000)).toEqual({ ageMs: null, rateHz: 19 });
  expect(meter.newestServerMs).toBeNull();
});

it("never takes a late frame for the newest", () => {
  meter.presented(9000, 120);
  meter.presented(0, 130);
  expect(meter.newestServerMs).toBe(10_100);
});

it("forgets all with a fresh peer", () => {
  meter.presented(0, 40);
  meter.reset();
  expect(meter.take(100)).toEqual({ ageMs: null, rateHz: 0 });
});
