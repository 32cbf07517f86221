/** What a big screen shows of the room, and what its address says. Pure. */

import type { RoomState } from "../messages";

/** How many watch, without the operator and this screen; `told` if not all are named. */
export function watchers(room: RoomState, me: number | undefined, told: number | null): number {
  if (told !== null) return told;
  const others = room.viewers.filter((one) => one.role !== "operator" && one.id !== me);
  return others.filter((one) => !one.lost).length;
}

/** Seconds as `0:07` and `1:30`. */
export function clockWords(seconds: number): string {
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

/** Where people join: this page's address without the view. */
export function joinAddress({ origin, pathname }: Pick<Location, "origin" | "pathname">): string {
  return origin + pathname;
}

/** Whether only this machine can open this address. */
export function isOnlyHere(hostname: string): boolean {
  return /^(localhost|127\.\d+\.\d+\.\d+|\[::1\])$/.test(hostname) || /\.localhost$/.test(hostname);
}

/** Whether the address asks for sound: `&sound=on`. */
export function wantsSound(search: string): boolean {
  return new URLSearchParams(search).get("sound") === "on";
}
