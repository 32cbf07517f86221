/** What to tell a viewer who missed the call to their turn; the call: `view/CallCard.tsx`. Pure. */

import type { RoomState } from "./messages";

/** What became of this viewer's place after a missed call; null if they missed none. */
export type MissedCall = "kept" | "lost" | null;

/** The server ends a call at its deadline; this covers the error of the page's clock. */
const SLACK_MS = 1000;

/**
 * Returns what to tell viewer `me` after this room state, given what they were told before. Pure.
 *
 * A call that ends before its deadline was answered, or its viewer left. The first missed call
 * keeps the viewer's place.
 */
export function missedCall(
  before: RoomState | null,
  after: RoomState,
  me: number,
  serverMs: number | null,
  told: MissedCall,
): MissedCall {
  const role = after.viewers.find((one) => one.id === me)?.role;
  if (after.call?.viewer === me || role === "operator") return null;
  const call = before?.call;
  const isOver =
    call?.viewer === me && serverMs !== null && serverMs >= call.until_server_ms - SLACK_MS;
  if (isOver) return role === "queued" ? "kept" : "lost";
  return told === "kept" && role !== "queued" ? null : told;
}
