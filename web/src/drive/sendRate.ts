/** What is known about the uplink before a set-point is sent. */
export interface Uplink {
  /** The server's estimate of the link to this page; null before the first. */
  linkBps: number | null;
  /** The bytes queued in the browser. */
  waitingBytes: number;
  /** How long the newest ping and its answer queued on the way. */
  queuedMs: number;
}

/** At a lower rate a single loss is noticeable; at this one a modem's uplink is full. */
export const FLOOR_HZ = 20;
/** A set-point with its SCTP, DTLS, UDP and IP headers. */
export const SET_POINT_BITS = 190 * 8;
/** Only the downlink is measured; the uplink is often a tenth of it. */
const UPLINK_SHARE = 0.1;
/** More than a set-point and a ping: the uplink does not keep up. */
export const WAITING_BYTES = 200;
/** More than a modem's jitter: a thin uplink carries less than even the floor. */
const QUEUED_MS = 60;
/** Then a loss stops the robot for a moment, but what arrives is no older than the link makes it. */
const CONGESTED_HZ = 10;
const CLIMB_HZ_PER_S = 5;
/**
 * While nothing is held: the server must know that before the next press may move anything. Over a
 * link that is slow, or unknown yet, whose uplink they might fill, it is as often as while they queue.
 */
const REST_HZ = 20;

/**
 * The rate of set-points: as high as the server allows, lower on a slow link, at least 20 a second
 * while they do not queue, fewer at rest. It falls at once, because a backlog delays a stop, and
 * rises slowly. Pure.
 */
export class SendRate {
  #last: { hz: number; atMs: number } | null = null;
  /** The most in Hz while nothing is held. */
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
