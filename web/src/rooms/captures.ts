import type { RtpClock } from "../messages";

/** From the beginning of NTP's time, 1900, to 1970. */
const NTP_MS = 2_208_988_800_000;
const RATES_HZ = { audio: 48_000, video: 90_000 };

/** abs-capture-time (webrtc-extensions 7.1), which only some browsers read. */
export type Source = RTCRtpSynchronizationSource & { captureTimestamp?: number };

/** How RTP time maps to capture time, by the newest packet's own word; null if it has none. */
export function rtpClock(kind: RtpClock["kind"], source: Source | undefined): RtpClock | null {
  if (source?.captureTimestamp === undefined) return null;
  return {
    type: "rtp_clock",
    kind,
    rtp_origin: source.rtpTimestamp,
    rate_hz: RATES_HZ[kind],
    origin_server_ms: source.captureTimestamp - NTP_MS,
  };
}

/**
 * A clock by which ages can be compared, though nobody knows how far the robot's is from the page's:
 * what came the fastest is of age 0. Sound and picture have the same error, so their skew has none.
 */
export class CaptureClock {
  #offsetMs: number | null = null;
  readonly rttMs = null;

  /** Takes what was captured then and is here now. */
  add(capturedMs: number, pageMs: number): void {
    this.#offsetMs = Math.max(this.#offsetMs ?? Number.NEGATIVE_INFINITY, capturedMs - pageMs);
  }

  toServerMs(pageMs: number): number | null {
    return this.#offsetMs === null ? null : pageMs + this.#offsetMs;
  }

  errorMs(): null {
    return null;
  }
}
