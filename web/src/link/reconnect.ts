/**
 * When to retry after losing a connection: at once, soon, every second for 20 s, then less often;
 * and how long an attempt may take.
 */

/** A phone finds another network within these, and not every browser reports that. */
const FIRST_MS = [0, 300, 400, 400, 400, 400, 400] as const;
const EACH_MS = 1000;
const EACH_COUNT = 20;
const SLOWER_MS = [2000, 4000, 8000] as const;
/** 10 s with the largest jitter. */
const LAST_MS = 8300;
const JITTER = 0.2;

/** An attempt younger than this need not be given up for another. */
const FRESH_MS = 250;
/** An attempt over an unknown or slow link may take this long. */
const UNKNOWN_MS = 10_000;
/** A connection, a request and its answer take two round trips; the third is for a lost packet. */
const ROUND_TRIPS = 3;
/** Round trips just before the loss may have been longer than the link's usual ones. */
const MAX_TRIPS_MS = 3000;

/**
 * Returns how long after the start of the previous attempt this one starts; `attempt` counts from
 * 0, the first after the loss. `random`, in 0…1, varies it by a fifth either way, so that not all
 * pages return at the same instant after the server restarts.
 */
export function attemptAfterMs(attempt: number, random: number): number {
  const slower = attempt - FIRST_MS.length - EACH_COUNT;
  const afterMs = FIRST_MS[attempt] ?? (slower < 0 ? EACH_MS : (SLOWER_MS[slower] ?? LAST_MS));
  return afterMs * (1 + JITTER * (2 * random - 1));
}

/** What is known of the link that was lost; null if there has been none. */
export interface LostLink {
  roundTripMs: number;
  isThin: boolean;
}

/**
 * Returns how long an attempt may wait for the server's answer. On a dead link it must end soon,
 * because retransmits back off; on a slow link it must not.
 */
export function patienceMs(nextAfterMs: number, link: LostLink | null): number {
  if (!link || link.isThin) return Math.max(nextAfterMs, UNKNOWN_MS);
  return nextAfterMs + Math.min(ROUND_TRIPS * link.roundTripMs, MAX_TRIPS_MS);
}

/** Returns how long an attempt is never restarted: on a thin link nothing is fast. */
export function freshMs(isThin: boolean): number {
  return isThin ? UNKNOWN_MS : FRESH_MS;
}
