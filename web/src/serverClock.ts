/**
 * The page's estimate of the server's clock.
 *
 * One ping and its pong bound the offset between the two clocks: the server read its clock
 * somewhere between sending and receiving, so the middle is off by at most half the round trip. The
 * exchange with the smallest bound in the window wins; a bound widens with its age, because the two
 * clocks drift apart. A delay spike in one direction lengthens the round trip and so never wins.
 */

/** The page sent at `sentMs` and received at `receivedMs` (its own clock) the time `serverMs`. */
export interface Exchange {
  sentMs: number;
  receivedMs: number;
  serverMs: number;
}

interface Bound {
  atMs: number;
  offsetMs: number;
  halfMs: number;
}

const WINDOW_MS = 20_000;
/** Two crystals differ by tens of parts per million; even the worst pair stays below this. */
const DRIFT = 200e-6;
/** Browsers round their clock, some to 1 ms at either end of the exchange. */
const ROUNDING_MS = 2;
const RECENT = 5;

export class ServerClock {
  #bounds: Bound[] = [];
  #best: Bound | null = null;
  #recentMs: number[] = [];

  /** Adds an exchange; one that ends before it began is ignored. */
  add({ sentMs, receivedMs, serverMs }: Exchange): void {
    const rttMs = receivedMs - sentMs;
    if (!(rttMs >= 0)) return;
    const bound = {
      atMs: receivedMs,
      offsetMs: serverMs - (sentMs + receivedMs) / 2,
      halfMs: rttMs / 2,
    };
    if (this.#contradicts(bound)) this.#bounds = [];
    this.#bounds.push(bound);
    this.#bounds = this.#bounds.filter((old) => old.atMs > receivedMs - WINDOW_MS);
    // All bounds widen at the same pace, so the order found now holds until the next exchange.
    this.#best = this.#bounds.reduce((a, b) =>
      width(b, receivedMs) < width(a, receivedMs) ? b : a,
    );
    this.#recentMs = [...this.#recentMs, rttMs].slice(-RECENT);
  }

  /** Converts a time of the page's clock to the server's; null before the first exchange. */
  toServerMs(pageMs: number): number | null {
    return this.#best && pageMs + this.#best.offsetMs;
  }

  /** The largest possible error of `toServerMs`; null before the first exchange. */
  errorMs(pageMs: number): number | null {
    return this.#best && width(this.#best, pageMs);
  }

  /** The median of the last few round trips; null before the first. */
  get rttMs(): number | null {
    const sorted = this.#recentMs.toSorted((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? null;
  }

  /** By how much the newest round trip exceeds the shortest of 20 s: its queueing delay. */
  get queuedMs(): number {
    const newestMs = this.#recentMs.at(-1) ?? 0;
    return newestMs - Math.min(newestMs, ...this.#bounds.map(({ halfMs }) => 2 * halfMs));
  }

  /** The longest of the last few round trips; null before the first. */
  get slowestMs(): number | null {
    return this.#recentMs.length > 0 ? Math.max(...this.#recentMs) : null;
  }

  /** Valid bounds overlap; these do not if a clock jumped, as after the machine slept. */
  #contradicts(bound: Bound): boolean {
    if (!this.#best) return false;
    const apartMs = Math.abs(bound.offsetMs - this.#best.offsetMs);
    return apartMs > bound.halfMs + width(this.#best, bound.atMs) + ROUNDING_MS;
  }
}

function width(bound: Bound, nowMs: number): number {
  return bound.halfMs + DRIFT * Math.max(0, nowMs - bound.atMs);
}
