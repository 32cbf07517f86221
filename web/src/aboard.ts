import type { AboardInfo, RoomState } from "./messages";

/** What the person aboard can ask for. */
export type Asked = NonNullable<AboardInfo["asked"]>;

/** What the person aboard has asked for since `before`; null for nothing new. Pure. */
export function newRequest(before: RoomState | null, after: RoomState): Asked | null {
  // A request made before this page connected is not new.
  if (!before?.aboard || !after.aboard) return null;
  return after.aboard.asks === before.aboard.asks ? null : after.aboard.asked;
}
