import { OPUS_HZ } from "./opus";

const MS = OPUS_HZ / 1000;
/** Longer than the pauses between the stalls of usual links, short enough to forget one's move. */
const WINDOW = 8 * OPUS_HZ;
/** Of the packets that came within the window, so many are in time. */
const QUANTILE = 0.985;
/** The later ones are waited for, too, where that costs no more than this. */
const TAIL = 10 * MS;
/** By how much the rate lags behind a device whose clock is off (100 ppm), and a little more. */
const MARGIN = 1.5 * MS;
/** So many packets are always known. */
const LEAST = 20;
const REVIEW_EVERY = OPUS_HZ / 10;
/** No sound waits longer: the thesis's audio media unit. */
const MOST = 500 * MS;

/**
 * How long after the fastest packet the sound is to play, so that hardly one comes too late.
 *
 * A packet's delay is when it arrived, by the device's clock, less its RTP time: only differences
 * count (the relative delay of NetEq's histogram). The target is a quantile of the delays in a
 * sliding window, and the rest of them where that is cheap. All in samples. Pure. How fast playing
 * follows a new target: `soundPlayer.ts`.
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
    // The first packets know nothing of the link, but a late one moves the target at once.
    if (this.#delays.length < 2 * LEAST) this.#reviewed = Number.NEGATIVE_INFINITY;
  }

  /** The delay at which to play, in the same terms; only to be asked once something has come. */
  at(frame: number): number {
    if (frame - this.#reviewed >= REVIEW_EVERY) {
      this.#reviewed = frame;
      this.#review(frame);
    }
    return this.#value;
  }

  /** Forgets everything: the device has stood still, or the sender is another. */
  clear(): void {
    this.#delays.length = 0;
    this.#frames.length = 0;
    this.#reviewed = Number.NEGATIVE_INFINITY;
    this.#began = null;
  }

  #review(frame: number): void {
    // A stream often begins behind a queue that is gone soon.
    const window = Math.min(WINDOW, (frame - (this.#began ?? frame)) / 2);
    let old = 0;
    // Where nothing comes any more, what came last stays known.
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
