/** What to tell whoever missed their call to a turn; the call itself: `view/CallCard.tsx`. Pure. */

import type { RoomState } from "./messages";

/** What became of a call that this viewer has not answered; null if they missed none. */
export type MissedCall = "kept" | "lost" | null;

/** The server ends a call when its time is over, give or take the error of the page's clock. */
const SLACK_MS = 1000;

/**
 * Returns what to tell a viewer after the next room, from what they were told before. Pure.
 *
 * A call that ends before its time was answered, or the caller has left; one that is missed keeps
 * the place once.
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
