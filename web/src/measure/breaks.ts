/** The number of interruptions in the last minute, and the longest; null if unknown. */
export interface Breaks {
  count: number;
  longestMs: number;
}

const WINDOW_MS = 60_000;

/** Gaps in the sound or freezes of the picture, from samples of counters. */
export class LastMinute {
  #breaks: { atMs: number; lengthMs: number }[] = [];

  /** Interruptions shorter than `leastMs` do not count. */
  constructor(private readonly leastMs: number) {}

  /**
   * Adds a sample: since the last one `count` interruptions began and together lasted `lengthMs`.
   * Several in one sample are assumed to be equally long; if none began, an earlier one continued.
   */
  add(atMs: number, count: number, lengthMs: number): void {
    if (lengthMs <= 0) return;
    const last = this.#breaks.at(-1);
    if (count === 0 && last) {
      last.lengthMs += lengthMs;
      last.atMs = atMs;
    }
    for (let i = 0; i < count; i++) this.#breaks.push({ atMs, lengthMs: lengthMs / count });
  }

  summarize(nowMs: number): Breaks {
    this.#breaks = this.#breaks.filter((one) => one.atMs > nowMs - WINDOW_MS);
    const lengths = this.#breaks.map((one) => one.lengthMs).filter((ms) => ms >= this.leastMs);
    return { count: lengths.length, longestMs: Math.max(0, ...lengths) };
  }
}
