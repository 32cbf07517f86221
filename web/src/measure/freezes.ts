const REMEMBERED = 30;
const LONGER_MS = 150;
const TIMES_LONGER = 3;

/**
 * Freezes of the picture by the rule of webrtc-stats (`freezeCount`), for browsers that do not
 * count them: a frame shown for longer than three times the mean of the last thirty, and for longer
 * than that mean plus 150 ms.
 */
export class Freezes {
  count = 0;
  totalMs = 0;
  #lastMs: number | null = null;
  #gapsMs: number[] = [];

  /** Records a presented frame; one reported out of order is ignored. */
  presented(atMs: number): void {
    const gapMs = atMs - (this.#lastMs ?? atMs);
    if (gapMs < 0) return;
    if (this.#lastMs !== null) this.#stood(gapMs);
    this.#lastMs = atMs;
  }

  /** Pauses counting: the time until the next frame does not count as a freeze. */
  rest(): void {
    this.#lastMs = null;
  }

  #stood(gapMs: number): void {
    const meanMs = this.#gapsMs.reduce((sum, one) => sum + one, 0) / this.#gapsMs.length;
    if (gapMs > Math.max(TIMES_LONGER * meanMs, meanMs + LONGER_MS)) {
      this.count++;
      this.totalMs += gapMs;
    }
    this.#gapsMs = [...this.#gapsMs, gapMs].slice(-REMEMBERED);
  }
}
