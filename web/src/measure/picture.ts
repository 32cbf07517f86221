import { Freezes } from "./freezes";
import type { RtpTimeline } from "./rtp";

const RATE_WINDOW_MS = 1000;
/** Without a frame for this long, the picture's age is that of the one that still stands there. */
const STANDING_MS = 500;
/** No picture is seen before it was taken; beyond the error of the clocks it is another stream's. */
const MAX_AHEAD_MS = 500;

export interface PictureFacts {
  /** Capture to presentation in ms, of the last frames; null where the browser does not tell. */
  ageMs: number | null;
  /** Frames presented in the last second. */
  rateHz: number;
}

/** How old the presented frames are. All times but those named so are on the page's clock. */
export class PictureMeter {
  /** Capture time of the newest presented frame, on the server's clock; null while unknown. */
  newestServerMs: number | null = null;
  freezes = new Freezes();
  #ages: number[] = [];
  #shown: number[] = [];

  constructor(
    private readonly timeline: RtpTimeline,
    private readonly toServerMs: (pageMs: number) => number | null,
  ) {}

  /** Notes that the frame with this RTP time is seen at `atMs`. */
  presented(rtp: number | undefined, atMs: number): void {
    this.#shown.push(atMs);
    this.freezes.presented(atMs);
    const capturedMs = this.timeline.capturedMs(rtp);
    const serverMs = this.toServerMs(atMs);
    if (capturedMs === null || serverMs === null) return;
    if (capturedMs > serverMs + MAX_AHEAD_MS) return;
    this.newestServerMs = Math.max(capturedMs, this.newestServerMs ?? capturedMs);
    this.#ages.push(serverMs - capturedMs);
  }

  /** What was measured since the last call. */
  take(nowMs: number): PictureFacts {
    this.#shown = this.#shown.filter((atMs) => atMs > nowMs - RATE_WINDOW_MS);
    const ages = this.#ages.splice(0);
    const mean = ages.reduce((sum, age) => sum + age, 0) / ages.length;
    return {
      ageMs: ages.length > 0 ? mean : this.#standingAgeMs(nowMs),
      rateHz: this.#shown.length,
    };
  }

  /** The picture is switched off or on: what was seen before tells nothing of now. */
  unsee(): void {
    this.newestServerMs = null;
  }

  /** Forgets everything; a fresh peer's frames are other frames. */
  reset(): void {
    this.newestServerMs = null;
    this.freezes = new Freezes();
    this.#ages = [];
    this.#shown = [];
  }

  #standingAgeMs(nowMs: number): number | null {
    const serverMs = this.toServerMs(nowMs);
    if (serverMs === null || this.newestServerMs === null) return null;
    const ageMs = serverMs - this.newestServerMs;
    return ageMs > STANDING_MS ? ageMs : null;
  }
}

/** Whether this browser tells of the frames that it presents; else nobody knows what is seen. */
export function tellsFrames(): boolean {
  return "requestVideoFrameCallback" in HTMLVideoElement.prototype;
}

/**
 * Tells the meter of every frame that this element presents; returns what ends it.
 *
 * Chromium, Firefox and Safari name a frame's RTP time (video-rvfc, `rtpTimestamp`). Where a
 * browser does not, the receiver's newest counts (webrtc-pc 5.3.1: of the frame last delivered to
 * the track) as it was at the frame *before*: delivered then, it is on the screen by now. That is
 * a picture too old, never one too new.
 */
export function watchFrames(
  video: HTMLVideoElement,
  meter: Pick<PictureMeter, "presented">,
  receiver: () => RTCRtpReceiver | undefined,
): () => void {
  if (!("requestVideoFrameCallback" in video)) return () => {};
  let handle = 0;
  let delivered: { by: RTCRtpReceiver; rtp: number | undefined } | null = null;
  const deliveredBefore = () => {
    const by = receiver();
    const before = delivered?.by === by ? delivered?.rtp : undefined;
    delivered = by ? { by, rtp: by.getSynchronizationSources()[0]?.rtpTimestamp } : null;
    return before;
  };
  const onFrame: VideoFrameRequestCallback = (nowMs, metadata) => {
    const rtp = metadata.rtpTimestamp ?? deliveredBefore();
    meter.presented(rtp, metadata.presentationTime || nowMs);
    handle = video.requestVideoFrameCallback(onFrame);
  };
  handle = video.requestVideoFrameCallback(onFrame);
  return () => video.cancelVideoFrameCallback(handle);
}
