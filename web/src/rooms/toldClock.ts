/** Older messages no longer count, because the two clocks drift apart. */
const WINDOW_MS = 20_000;

/**
 * The server's clock for a page that only receives: each message says when it was sent, and the
 * fastest is the most accurate. Good enough for a countdown. Pure.
 */
export class ToldClock {
  #told: { atMs: number; offsetMs: number }[] = [];

  add(serverMs: number, receivedMs: number): void {
    const recent = this.#told.filter((one) => one.atMs > receivedMs - WINDOW_MS);
    this.#told = [...recent, { atMs: receivedMs, offsetMs: serverMs - receivedMs }];
  }

  /** Converts a time of the page's clock to the server's; null before the first message. */
  toServerMs(pageMs: number): number | null {
    if (this.#told.length === 0) return null;
    return pageMs + Math.max(...this.#told.map((one) => one.offsetMs));
  }
}
