import type { RtpClock } from "../messages";

/** Maps the RTP timestamps of one stream to the moments of capture, as the server told. */
export class RtpTimeline {
  #origin: RtpClock | null = null;

  /** Takes the newest mapping, null for none: a fresh peer counts anew. */
  set(origin: RtpClock | null): void {
    this.#origin = origin;
  }

  /**
   * When the sample with this RTP time was captured, on the server's clock in ms; null while
   * unknown. RTP time wraps at 2³² (RFC 3550 5.1): the moment nearest to the origin is meant.
   */
  capturedMs(rtp: number | undefined): number | null {
    if (!this.#origin || rtp === undefined) return null;
    const ticks = (rtp - this.#origin.rtp_origin) | 0;
    return this.#origin.origin_server_ms + (ticks * 1000) / this.#origin.rate_hz;
  }
}
