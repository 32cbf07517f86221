/** The age and rate of the pictures on screen; when one is too old: `view/live.ts`. */

import { Freezes } from "./freezes";
import type { RtpTimeline } from "./rtp";

const RATE_WINDOW_MS = 1000;
/** Without a frame for this long, the age is that of the frame still on screen. */
const STANDING_MS = 500;
/** A frame further in the future than the clocks can err belongs to another stream. */
const MAX_AHEAD_MS = 500;

export interface PictureFacts {
  /** Capture to presentation in ms, over the last frames; null if the browser does not report it. */
  ageMs: number | null;
  /** Frames presented in the last second. */
  rateHz: number;
}

/** The age of the presented frames. Times are on the page's clock unless their name says otherwise. */
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

  /** Records that the frame with this RTP time is presented at `atMs`. */
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

  /** Returns the measurements since the last call. */
  flush(nowMs: number): PictureFacts {
    this.#shown = this.#shown.filter((atMs) => atMs > nowMs - RATE_WINDOW_MS);
    const ages = this.#ages.splice(0);
    const mean = ages.reduce((sum, age) => sum + age, 0) / ages.length;
    return {
      ageMs: ages.length > 0 ? mean : this.#standingAgeMs(nowMs),
      rateHz: this.#shown.length,
    };
  }

  /** Forgets earlier frames, because the picture was switched off or on. */
  unsee(): void {
    this.newestServerMs = null;
  }

  /** Forgets everything, for a new peer. */
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

/** Whether this browser reports presented frames; otherwise nobody knows what is on screen. */
export function tellsFrames(): boolean {
  return "requestVideoFrameCallback" in HTMLVideoElement.prototype;
}

/**
 * Passes every frame that this element presents to the meter; returns a function that stops it.
 *
 * Chromium, Firefox and Safari report a frame's RTP time (video-rvfc, `rtpTimestamp`). For other
 * browsers the receiver's newest counts (webrtc-pc 5.3.1: of the frame last delivered to the
 * track) as it was at the *previous* frame: delivered then, it is on screen by now. The error is one
 * frame too old, never too new.
 */
export function watchFrames(
  video: HTMLVideoElement,
  meter: Pick<PictureMeter, "presented">,
  receiver: () => RTCRtpReceiver | undefined,
): () => void {
  const request = video.requestVideoFrameCallback?.bind(video);
  if (!request) return () => {};
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
    handle = request(onFrame);
  };
  handle = request(onFrame);
  return () => video.cancelVideoFrameCallback?.(handle);
}
