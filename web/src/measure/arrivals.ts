/** How many pictures arrive in a second, from a receiver's counter. Pure. */
export class Arrivals {
  #last: { count: number; atMs: number } | null = null;

  /** The mean rate since the last call; null at first, and where the counter restarts. */
  next(count: number | undefined, atMs: number): number | null {
    const last = this.#last;
    this.#last = count === undefined ? null : { count, atMs };
    if (!last || count === undefined || count < last.count || atMs <= last.atMs) return null;
    return ((count - last.count) * 1000) / (atMs - last.atMs);
  }
}
