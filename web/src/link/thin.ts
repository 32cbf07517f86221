/** Which link is thin, and when nothing more may load; parts that wait: `view/late.tsx`. Pure. */

import type { Served } from "../messages";

/** On a slower link than this, the page's own traffic matters. */
const THIN_BPS = 100_000;

export function isThin(served: Pick<Served, "link_bps">): boolean {
  return served.link_bps < THIN_BPS;
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
