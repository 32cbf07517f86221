import type { Units } from "../messages";

/** How many packets to remember until it is known which of them end a unit. */
const MAX_REMEMBERED = 256;

/** Finds the packets that end a media unit of the sound. Pure. */
export class SoundUnits {
  #units: Units | null = null;
  #early: number[] = [];

  /** Sets which packets end a unit; returns those already received. */
  set(units: Units): number[] {
    this.#units = units;
    const early = this.#early.filter((rtp) => this.#isLast(rtp, units));
    this.#early = [];
    return early;
  }

  /** Forgets the previous peer. */
  reset(): void {
    this.#units = null;
    this.#early = [];
  }

  /** Whether the packet with this RTP time ends a unit; false while that is unknown. */
  isLast(rtp: number): boolean {
    if (this.#units) return this.#isLast(rtp, this.#units);
    this.#early.push(rtp);
    if (this.#early.length > MAX_REMEMBERED) this.#early.shift();
    return false;
  }

  /** RTP time wraps at 2³² (RFC 3550 5.1), and late packets lie before the named one. */
  #isLast(rtp: number, units: Units): boolean {
    return ((rtp - units.last_rtp) | 0) % units.length === 0;
  }
}
