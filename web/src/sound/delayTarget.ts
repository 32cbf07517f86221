import { OPUS_HZ } from "./opus";

const MS = OPUS_HZ / 1000;
/** Longer than the pauses between usual stalls, short enough to forget a change of place. */
const WINDOW = 8 * OPUS_HZ;
/** The share of the packets in the window that must be in time. */
const QUANTILE = 0.985;
/** The later ones are waited for, too, if that adds no more than this. */
const TAIL = 10 * MS;
/** By how much playing lags behind a device whose clock is off (100 ppm), and a little more. */
const MARGIN = 1.5 * MS;
/** At least this many packets are remembered. */
const LEAST = 20;
const REVIEW_EVERY = OPUS_HZ / 10;
/** The longest wait: the thesis's audio media unit. */
const MOST = 500 * MS;

/**
 * How long after the fastest packet the sound should play, so that hardly any packet is late.
 *
 * A packet's delay is its arrival by the device's clock minus its RTP time: only differences matter
 * (the relative delay of NetEq's histogram). The target is a quantile of the delays in a sliding
 * window, or all of them where that is cheap. All in samples. Pure. How fast playing follows a new
 * target: `soundPlayer.ts`.
 */
export class DelayTarget {
  readonly #delays: number[] = [];
  readonly #frames: number[] = [];
  #reviewed = Number.NEGATIVE_INFINITY;
  #began: number | null = null;
  #value = 0;
  /** The delay of the fastest packet. */
  least = 0;

  /** Adds the delay of a packet that arrived at this frame of the device. */
  add(delay: number, frame: number): void {
    this.#began ??= frame;
    this.#delays.push(delay);
    this.#frames.push(frame);
    // While few packets are known, each one moves the target at once.
    if (this.#delays.length < 2 * LEAST) this.#reviewed = Number.NEGATIVE_INFINITY;
  }

  /** The delay at which to play, in the terms of `add`; call it only after the first packet. */
  at(frame: number): number {
    if (frame - this.#reviewed >= REVIEW_EVERY) {
      this.#reviewed = frame;
      this.#review(frame);
    }
    return this.#value;
  }

  /** Forgets everything, because the device has stalled or the sender has changed. */
  clear(): void {
    this.#delays.length = 0;
    this.#frames.length = 0;
    this.#reviewed = Number.NEGATIVE_INFINITY;
    this.#began = null;
  }

  #review(frame: number): void {
    // A stream often starts behind a queue that soon drains.
    const window = Math.min(WINDOW, (frame - (this.#began ?? frame)) / 2);
    let old = 0;
    // The last packets are remembered even when no more arrive.
    while (old < this.#frames.length - LEAST && (this.#frames[old] ?? 0) < frame - window) old++;
    this.#delays.splice(0, old);
    this.#frames.splice(0, old);
    const sorted = Float64Array.from(this.#delays).sort();
    const last = sorted.length - 1;
    if (last < 0) return;
    this.least = sorted[0] ?? 0;
    const most = sorted[last] ?? 0;
    const usual = sorted[Math.floor(last * QUANTILE)] ?? 0;
    this.#value = Math.min(Math.min(most, usual + TAIL) + MARGIN, this.least + MOST);
  }
}
