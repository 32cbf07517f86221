/** What can be known of the way before a set-point goes out. */
export interface Way {
  /** What the server has measured of the link to this page; null before it has told. */
  linkBps: number | null;
  /** What still waits in the browser to be sent. */
  waitingBytes: number;
}

/** With fewer, a single loss is felt; with so many, a modem's uplink is full. */
const FLOOR_HZ = 20;
/** A set-point with all that is wrapped around it: SCTP, DTLS, UDP and IP. */
const SET_POINT_BITS = 190 * 8;
/** Of a link only the way here is measured; the way back is often a tenth of it. */
const UPLINK_SHARE = 0.1;
/** More than a set-point and a ping: the way does not keep up. */
const WAITING_BYTES = 200;
const CLIMB_HZ_PER_S = 5;

/**
 * How often set-points go out: as often as the server allows, less on a thin link, 20 times a
 * second at least. At once down, since what waits makes a stop late; slowly up. Pure.
 */
export class Rate {
  #last: { hz: number; atMs: number } | null = null;

  constructor(private readonly maxHz: number) {}

  /** The rate in Hz from now on. */
  next({ linkBps, waitingBytes }: Way, nowMs: number): number {
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
