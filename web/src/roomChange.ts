import type { RoomChange, RoomState } from "./messages";

/** The room after this change, its viewers in the order of arrival. */
export function changed(room: RoomState, change: RoomChange): RoomState {
  const { gone, ...rest } = change;
  const lines = new Map([...room.viewers, ...change.viewers].map((line) => [line.id, line]));
  for (const number of gone) lines.delete(number);
  const viewers = [...lines.values()].sort((one, other) => one.id - other.id);
  return { ...room, ...rest, type: "room", viewers };
}
