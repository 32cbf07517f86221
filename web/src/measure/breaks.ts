/** How often something broke in the last minute, and the longest of it; null where unknown. */
export interface Breaks {
  count: number;
  longestMs: number;
}

const WINDOW_MS = 60_000;

/** Pauses of the sound or freezes of the picture, as counters tell of them look by look. */
export class LastMinute {
  #breaks: { atMs: number; lengthMs: number }[] = [];

  /** What is shorter than `leastMs` is none. */
  constructor(private readonly leastMs: number) {}

  /**
   * Since the last look `count` breaks began and all together lasted `lengthMs`: several within
   * one look are taken for equally long, and none that began for one that went on.
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

  take(nowMs: number): Breaks {
    this.#breaks = this.#breaks.filter((one) => one.atMs > nowMs - WINDOW_MS);
    const lengths = this.#breaks.map((one) => one.lengthMs).filter((ms) => ms >= this.leastMs);
    return { count: lengths.length, longestMs: Math.max(0, ...lengths) };
  }
}
