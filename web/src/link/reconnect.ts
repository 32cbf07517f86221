/**
 * When to try again after losing a connection: at once, soon, each second for 20 s, then less often;
 * and how long an attempt may take.
 */

/** A phone finds another network in so long, and not every browser tells. */
const FIRST_MS = [0, 300, 400, 400, 400, 400, 400] as const;
const EACH_MS = 1000;
const EACH_COUNT = 20;
const SLOWER_MS = [2000, 4000, 8000] as const;
/** With the largest jitter it is 10 s. */
const LAST_MS = 8300;
const JITTER = 0.2;

/** An attempt that has just begun need not be given up for another. */
const FRESH_MS = 250;
/** An attempt over a link of which nothing is known, or which is slow, may take this long. */
const UNKNOWN_MS = 10_000;
/** A connection, a request and its answer take two round trips; the third is for a lost packet. */
const ROUND_TRIPS = 3;
/** The last ones before the loss may have been longer than the link's own. */
const MAX_TRIPS_MS = 3000;

/**
 * Returns the time from the beginning of the attempt before this one; `attempt` counts from 0, the
 * first after the loss. `random` is in 0…1: from the second attempt on, a fifth more or less, so
 * that not everybody comes at the same instant after the server restarts.
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
 * Returns how long an attempt may wait for the server's answer. On a link that is dead it must end
 * soon, because what it sends is sent again less and less often; on a slow one it must not.
 */
export function patienceMs(nextAfterMs: number, link: LostLink | null): number {
  if (!link || link.isThin) return Math.max(nextAfterMs, UNKNOWN_MS);
  return nextAfterMs + Math.min(ROUND_TRIPS * link.roundTripMs, MAX_TRIPS_MS);
}

/** Returns how long an attempt goes on undisturbed, whatever comes: on a thin link nothing is fast. */
export function freshMs(isThin: boolean): number {
  return isThin ? UNKNOWN_MS : FRESH_MS;
}
