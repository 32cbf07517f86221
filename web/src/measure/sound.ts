/** The sound's age when it is heard; its gaps: `counts.ts`. */

import type { RtpTimeline } from "./rtp";

/** A source older than this is no longer playing. */
const CURRENT_MS = 1000;
/** Browsers differ: a time above this counts from 1970, one below from the page's start. */
const EPOCH_MS = 1e11;

/** The age of the sound when it plays; polled, since no browser reports each packet. */
export class SoundMeter {
  #ages: number[] = [];

  constructor(
    private readonly timeline: RtpTimeline,
    private readonly toServerMs: (pageMs: number) => number | null,
    private readonly timeOriginMs: number,
  ) {}

  /** Adds the receiver's data on the packet that is playing; undefined if there is none. */
  sample(source: RTCRtpSynchronizationSource | undefined, nowMs: number): void {
    if (!source) return;
    const { timestamp, rtpTimestamp } = source;
    const playedMs = timestamp > EPOCH_MS ? timestamp - this.timeOriginMs : timestamp;
    const serverMs = this.toServerMs(playedMs);
    const capturedMs = this.timeline.capturedMs(rtpTimestamp);
    if (Math.abs(nowMs - playedMs) > CURRENT_MS) return;
    if (serverMs === null || capturedMs === null) return;
    this.#ages.push(serverMs - capturedMs);
  }

  /** Adds that this RTP time is heard at `atMs` on the page's clock; returns its age. */
  heard(rtp: number, atMs: number): number | null {
    const serverMs = this.toServerMs(atMs);
    const capturedMs = this.timeline.capturedMs(rtp);
    if (serverMs === null || capturedMs === null) return null;
    this.#ages.push(serverMs - capturedMs);
    return serverMs - capturedMs;
  }

  /** The median age since the last call in ms, null without measurements. */
  flush(): number | null {
    const sorted = this.#ages.splice(0).sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? null;
  }
}
