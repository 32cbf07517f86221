/**
 * Mean delay between two looks at a pair of counters: the seconds that all pieces together were
 * delayed, and how many pieces there were (webrtc-stats: `jitterBufferDelay` and
 * `jitterBufferEmittedCount`, `totalPlayoutDelay` and `totalSamplesCount`).
 */
export class DelayMeter {
  #last: { totalS: number; count: number } | null = null;

  /** The mean in ms since the last call; null at first, and when nothing came out. */
  next(totalS: number | undefined, count: number | undefined): number | null {
    if (totalS === undefined || count === undefined) return null;
    const last = this.#last;
    this.#last = { totalS, count };
    if (!last || count <= last.count) return null;
    return ((totalS - last.totalS) / (count - last.count)) * 1000;
  }
}
