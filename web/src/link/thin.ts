/** Which link is thin, and when nothing more may load; parts that wait: `view/late.tsx`. Pure. */

import type { Served } from "../messages";

/** What the browser tells of a file that it has loaded. */
type Loaded = Pick<PerformanceResourceTiming, "transferSize" | "responseStart" | "responseEnd">;

/** On a slower link than this, the page's own traffic matters. */
const THIN_BPS = 100_000;

export function isThin(served: Pick<Served, "link_bps">): boolean {
  return served.link_bps < THIN_BPS;
}

/** A smaller file tells more of the round trip than of the rate; so much of the page is one file. */
const TELLING_BYTES = 20_000;

/** Whether the page itself came over a thin link. */
export function cameOverThin(loaded: readonly Loaded[]): boolean {
  return loaded.some(({ transferSize, responseStart, responseEnd }) => {
    const ms = responseEnd - responseStart;
    return transferSize >= TELLING_BYTES && (8000 * transferSize) / ms < THIN_BPS;
  });
}

/**
 * Whether nothing more may be loaded now: on a thin link, who drives needs all of it. While
 * nothing is known of the link it may be thin.
 */
export function isNeededForDriving(
  served: Pick<Served, "link_bps"> | null,
  drivingTurn: number | null,
): boolean {
  return drivingTurn !== null && (served === null || isThin(served));
}
