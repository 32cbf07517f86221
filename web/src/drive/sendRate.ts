/** What is known about the uplink before a set-point is sent. */
export interface Uplink {
  /** The server's estimate of the link to this page; null before the first. */
  linkBps: number | null;
  /** The bytes queued in the browser. */
  waitingBytes: number;
  /** The queueing delay of the newest ping and its answer. */
  queuedMs: number;
}

/** At a lower rate a single loss is noticeable; this rate fills a modem's uplink. */
export const FLOOR_HZ = 20;
/** The size of a set-point with its SCTP, DTLS, UDP and IP headers. */
export const SET_POINT_BITS = 190 * 8;
/** The uplink's assumed share of the downlink, the only direction that is measured. */
const UPLINK_SHARE = 0.1;
/** More queued than a set-point and a ping means that the uplink does not keep up. */
export const WAITING_BYTES = 200;
/** A delay beyond a modem's jitter means that a thin uplink carries not even the floor. */
const QUEUED_MS = 60;
/** The rate on such an uplink: a loss stops the robot for a moment, but commands do not queue. */
const CONGESTED_HZ = 10;
const CLIMB_HZ_PER_S = 5;
/**
 * The rate while nothing is held, which the server must know before the next press may move
 * anything. On a slow or still unknown link, whose uplink this might fill, it is `CONGESTED_HZ`.
 */
const REST_HZ = 20;

/**
 * The rate of set-points: as high as the server allows, lower on a slow link, at least 20 a second
 * unless they queue, fewer at rest. It falls at once, because a backlog delays a stop, and rises
 * slowly. Pure.
 */
export class SendRate {
  #last: { hz: number; atMs: number } | null = null;
  /** The highest rate while nothing is held. */
  restHz = CONGESTED_HZ;

  constructor(private readonly maxHz: number) {}

  /** Returns the rate in Hz from now on. */
  next({ linkBps, waitingBytes, queuedMs }: Uplink, nowMs: number): number {
    const carriedHz = ((linkBps ?? 0) * UPLINK_SHARE) / SET_POINT_BITS;
    this.restHz = carriedHz < FLOOR_HZ ? CONGESTED_HZ : REST_HZ;
    const isCongested = carriedHz < FLOOR_HZ && queuedMs > QUEUED_MS;
    const leastHz = isCongested ? CONGESTED_HZ : FLOOR_HZ;
    const isFull = isCongested || waitingBytes > WAITING_BYTES;
    const wantedHz = isFull ? leastHz : Math.max(FLOOR_HZ, carriedHz);
    const last = this.#last ?? { hz: wantedHz, atMs: nowMs };
    const climbedHz = last.hz + (CLIMB_HZ_PER_S * (nowMs - last.atMs)) / 1000;
    const hz = Math.min(wantedHz, climbedHz, this.maxHz);
    this.#last = { hz, atMs: nowMs };
    return hz;
  }
}
