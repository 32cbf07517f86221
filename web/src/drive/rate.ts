/** What is known about the uplink before a set-point is sent. */
export interface Uplink {
  /** The server's estimate of the link to this page; null before the first. */
  linkBps: number | null;
  /** The bytes queued in the browser. */
  waitingBytes: number;
}

/** At a lower rate a single loss is noticeable; at this one a modem's uplink is full. */
export const FLOOR_HZ = 20;
/** A set-point with its SCTP, DTLS, UDP and IP headers. */
const SET_POINT_BITS = 190 * 8;
/** Only the downlink is measured; the uplink is often a tenth of it. */
const UPLINK_SHARE = 0.1;
/** More than a set-point and a ping: the uplink does not keep up. */
const WAITING_BYTES = 200;
const CLIMB_HZ_PER_S = 5;

/**
 * The rate of set-points: as high as the server allows, lower on a slow link, at least 20 a second.
 * It falls at once, because a backlog delays a stop, and rises slowly. Pure.
 */
export class Rate {
  #last: { hz: number; atMs: number } | null = null;

  constructor(private readonly maxHz: number) {}

  /** Returns the rate in Hz from now on. */
  next({ linkBps, waitingBytes }: Uplink, nowMs: number): number {
    const floorHz = Math.min(FLOOR_HZ, this.maxHz);
    const carriedHz = ((linkBps ?? 0) * UPLINK_SHARE) / SET_POINT_BITS;
    const wantedHz = waitingBytes > WAITING_BYTES ? 0 : Math.min(carriedHz, this.maxHz);
    const last = this.#last ?? { hz: wantedHz, atMs: nowMs };
    const climbedHz = last.hz + (CLIMB_HZ_PER_S * (nowMs - last.atMs)) / 1000;
    const hz = Math.max(floorHz, Math.min(wantedHz, climbedHz));
    this.#last = { hz, atMs: nowMs };
    return hz;
  }
}
