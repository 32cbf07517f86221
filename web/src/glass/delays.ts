/** The delays of the pictures that were read lately. Pure. */

import { REPEATS_MS } from "./code";

/** A picture that was read: all of its delay, and the part that WAX knows; null while unknown. */
export interface Sight {
  totalMs: number;
  knownMs: number | null;
}

export interface Delays {
  count: number;
  /** The median, and what 95 % are below. */
  p50Ms: number;
  p95Ms: number;
  /** The median of what WAX does not know, null if it knows nothing. */
  restMs: number | null;
}

/** Enough for half a minute of the last past. */
const KEPT = 600;
/** A code that is older stands still, or its clock is wrong. */
const MOST_MS = 10_000;
/** A code may be this far in the future, by the error of both clocks. */
const AHEAD_MS = 1000;

/** How old a code of this time is; null if its clock or ours cannot be right. */
export function ageOf(codeMs: number, serverMs: number): number | null {
  const since = (serverMs - codeMs + AHEAD_MS) % REPEATS_MS;
  const ageMs = (since < 0 ? since + REPEATS_MS : since) - AHEAD_MS;
  return ageMs > MOST_MS ? null : ageMs;
}

/** Adds a picture, and forgets the oldest. */
export function withSight(sights: readonly Sight[], one: Sight): Sight[] {
  return [...sights, one].slice(-KEPT);
}

/** What these pictures come to; null without any. */
export function delaysOf(sights: readonly Sight[]): Delays | null {
  const p50Ms = percentile(
    sights.map(({ totalMs }) => totalMs),
    0.5,
  );
  const p95Ms = percentile(
    sights.map(({ totalMs }) => totalMs),
    0.95,
  );
  if (p50Ms === null || p95Ms === null) return null;
  const rests = sights.flatMap(({ totalMs, knownMs }) =>
    knownMs === null ? [] : [totalMs - knownMs],
  );
  return { count: sights.length, p50Ms, p95Ms, restMs: percentile(rests, 0.5) };
}

/** The smallest value that is at least as large as this share of them. */
function percentile(values: readonly number[], share: number): number | null {
  return values.toSorted((a, b) => a - b)[Math.ceil(share * values.length) - 1] ?? null;
}
