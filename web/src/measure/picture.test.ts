import { beforeEach, describe, expect, it } from "vitest";
import { PictureMeter, watchFrames } from "./picture";
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
  expect(meter.flush(200)).toEqual({ ageMs: 50, rateHz: 2 });
  expect(meter.newestServerMs).toBe(10_100);
});

it("reports the age of a frozen picture, but not while the next is merely due", () => {
  meter.presented(0, 40);
  meter.flush(50);
  expect(meter.flush(300).ageMs).toBeNull();
  expect(meter.flush(2000).ageMs).toBe(2000);
});

it("counts the frames of the last second, even without RTP times", () => {
  for (let at = 0; at < 2000; at += 50) meter.presented(undefined, at);
  expect(meter.flush(2000)).toEqual({ ageMs: null, rateHz: 19 });
  expect(meter.newestServerMs).toBeNull();
});

it("never counts a late frame as the newest", () => {
  meter.presented(9000, 120);
  meter.presented(0, 130);
  expect(meter.newestServerMs).toBe(10_100);
});

it("forgets everything for a new peer", () => {
  meter.presented(0, 40);
  meter.reset();
  expect(meter.flush(100)).toEqual({ ageMs: null, rateHz: 0 });
});

it("knows no capture time between switching the picture and the next frame", () => {
  meter.presented(0, 40);
  meter.unsee();
  expect(meter.newestServerMs).toBeNull();
  meter.presented(9000, 140);
  expect(meter.newestServerMs).toBe(10_100);
});

it("ignores a picture from the future", () => {
  meter.presented(90_000, 40);
  expect(meter.newestServerMs).toBeNull();
});

describe("what is on the screen", () => {
  let present: (rtpTimestamp: number | undefined, atMs: number) => void;
  let receiver: { delivered: number | undefined } & Pick<
    RTCRtpReceiver,
    "getSynchronizationSources"
  >;

  function makeReceiver() {
    return {
      delivered: undefined as number | undefined,
      getSynchronizationSources() {
        const { delivered } = this;
        return delivered === undefined
          ? []
          : [{ rtpTimestamp: delivered, source: 1, timestamp: 0 }];
      },
    };
  }

  beforeEach(() => {
    let callback: VideoFrameRequestCallback | undefined;
    const video = {
      requestVideoFrameCallback(next: VideoFrameRequestCallback) {
        callback = next;
        return 1;
      },
    } as HTMLVideoElement;
    receiver = makeReceiver();
    watchFrames(video, meter, () => receiver as unknown as RTCRtpReceiver);
    present = (rtpTimestamp, atMs) => {
      const metadata = {
        presentationTime: atMs,
        ...(rtpTimestamp !== undefined && { rtpTimestamp }),
      };
      callback?.(atMs, metadata as VideoFrameCallbackMetadata);
    };
  });

  it("is what the browser reports", () => {
    receiver.delivered = 90_000;
    present(9000, 140);
    expect(meter.newestServerMs).toBe(10_100);
  });

  it("is otherwise what the receiver had delivered by the previous frame", () => {
    receiver.delivered = 0;
    present(undefined, 40);
    expect(meter.newestServerMs).toBeNull();
    receiver.delivered = 9000;
    present(undefined, 140);
    expect(meter.newestServerMs).toBe(10_000);
    present(undefined, 240);
    expect(meter.newestServerMs).toBe(10_100);
  });

  it("is never what another connection's receiver delivered", () => {
    receiver.delivered = 9000;
    present(undefined, 140);
    receiver = makeReceiver();
    present(undefined, 180);
    expect(meter.newestServerMs).toBeNull();
  });
});
