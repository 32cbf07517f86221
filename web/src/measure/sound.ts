import type { RtpTimeline } from "./rtp";

/** What is older than this is no longer being heard. */
const CURRENT_MS = 1000;
/** A time above this counts from 1970, one below from the opening of the page: browsers differ. */
const EPOCH_MS = 1e11;

/** How old the sound is when it is played; polled, since no browser tells of each packet. */
export class SoundMeter {
  #ages: number[] = [];

  constructor(
    private readonly timeline: RtpTimeline,
    private readonly toServerMs: (pageMs: number) => number | null,
    private readonly timeOriginMs: number,
  ) {}

  /** Takes what the receiver tells of the packet that plays; undefined where it tells nothing. */
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

  /** The median age since the last call in ms, null where nothing could be measured. */
  take(): number | null {
    const sorted = this.#ages.splice(0).sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? null;
  }
}
