import type { RtpClock } from "../messages";

/** Maps the RTP timestamps of one stream to capture times, with the server's mapping. */
export class RtpTimeline {
  #origin: RtpClock | null = null;

  /** Sets the newest mapping; null for none, as for a new peer. */
  set(origin: RtpClock | null): void {
    this.#origin = origin;
  }

  /**
   * When the sample with this RTP time was captured, on the server's clock in ms; null while
   * unknown. RTP time wraps at 2³² (RFC 3550 5.1), so the result is the time nearest to the origin.
   */
  capturedMs(rtp: number | undefined): number | null {
    if (!this.#origin || rtp === undefined) return null;
    const ticks = (rtp - this.#origin.rtp_origin) | 0;
    return this.#origin.origin_server_ms + (ticks * 1000) / this.#origin.rate_hz;
  }
}
