/** When a link is thin, and when nothing more may load; parts that wait: `view/late.tsx`. Pure. */

import type { Served } from "../messages";

/** The browser's timing of a loaded file. */
type Loaded = Pick<PerformanceResourceTiming, "transferSize" | "responseStart" | "responseEnd">;

/** On a link slower than this, the page's own traffic matters. */
const THIN_BPS = 100_000;

export function isThin(served: Pick<Served, "link_bps">): boolean {
  return served.link_bps < THIN_BPS;
}

/** A smaller file's timing shows the round trip rather than the rate; one of ours is this large. */
const TELLING_BYTES = 20_000;

/** Whether the page itself came over a thin link. */
export function cameOverThin(loaded: readonly Loaded[]): boolean {
  return loaded.some(({ transferSize, responseStart, responseEnd }) => {
    const ms = responseEnd - responseStart;
    return transferSize >= TELLING_BYTES && (8000 * transferSize) / ms < THIN_BPS;
  });
}

/**
 * Whether nothing more may be loaded now, because driving needs all of a thin link. A link of
 * unknown rate may be thin.
 */
export function isNeededForDriving(
  served: Pick<Served, "link_bps"> | null,
  drivingTurn: number | null,
): boolean {
  return drivingTurn !== null && (served === null || isThin(served));
}
