import type { Units } from "../messages";

/** So many packets are remembered while it is not yet known which of them end a unit. */
const MAX_REMEMBERED = 256;

/** Tells the media units of the sound by their last packets. Pure. */
export class SoundUnits {
  #units: Units | null = null;
  #early: number[] = [];

  /** Learns which packets are last ones; returns those among what has come before. */
  set(units: Units): number[] {
    this.#units = units;
    const early = this.#early.filter((rtp) => this.#isLast(rtp, units));
    this.#early = [];
    return early;
  }

  /** Forgets the peer before. */
  reset(): void {
    this.#units = null;
    this.#early = [];
  }

  /** Whether the packet with this RTP time ends a unit; not before that can be known. */
  isLast(rtp: number): boolean {
    if (this.#units) return this.#isLast(rtp, this.#units);
    this.#early.push(rtp);
    if (this.#early.length > MAX_REMEMBERED) this.#early.shift();
    return false;
  }

  /** RTP time wraps at 2³² (RFC 3550 5.1), and late packets lie before the one that was named. */
  #isLast(rtp: number, units: Units): boolean {
    return ((rtp - units.last_rtp) | 0) % units.length === 0;
  }
}
