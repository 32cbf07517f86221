import type { RtpClock } from "../messages";

/** From NTP's epoch, 1900, to 1970. */
const NTP_MS = 2_208_988_800_000;
const RATES_HZ = { audio: 48_000, video: 90_000 };

/** abs-capture-time (webrtc-extensions 7.1), which only some browsers read. */
export type Source = RTCRtpSynchronizationSource & { captureTimestamp?: number };

/** How RTP time maps to capture time, by the newest packet's timestamp; null without one. */
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
 * A clock for comparing ages although the robot's offset from the page's clock is unknown: the
 * fastest sample counts as age 0. Sound and picture share the error, so their skew has none.
 */
export class CaptureClock {
  #offsetMs: number | null = null;
  readonly rttMs = null;

  /** Adds a sample's times of capture and arrival. */
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
