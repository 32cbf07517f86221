/**
 * The mean delay between two samples of a pair of counters: the total delay in seconds, and the
 * number of items (webrtc-stats: `jitterBufferDelay` and `jitterBufferEmittedCount`,
 * `totalPlayoutDelay` and `totalSamplesCount`).
 */
export class DelayMeter {
  #last: { totalS: number; count: number } | null = null;

  /** The mean in ms since the last call; null at first, and if there were no items. */
  next(totalS: number | undefined, count: number | undefined): number | null {
    if (totalS === undefined || count === undefined) return null;
    const last = this.#last;
    this.#last = { totalS, count };
    if (!last || count <= last.count) return null;
    return ((totalS - last.totalS) / (count - last.count)) * 1000;
  }
}
