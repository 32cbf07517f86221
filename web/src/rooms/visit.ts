import type { RoomState, ViewerInfo } from "../messages";

/** The page connects to the robot's server 10 s before its turn, by waits sent every second. */
const CONNECTS_S = 11;
/** A page with a longer wait than this disconnects; more than `CONNECTS_S`, as a hysteresis. */
const LEAVES_S = 20;

/** Whether this viewer's turn is so near that the page must be at the robot's own server. Pure. */
export function mustCome(room: RoomState, me: ViewerInfo): boolean {
  if (me.role === "operator" || room.call?.viewer === me.id) return true;
  if (me.role !== "queued") return false;
  // If the wait is unknown, the turn may begin now.
  if (me.wait_s === null) return me.place === 1;
  return me.wait_s <= CONNECTS_S;
}

/** Whether a page that connected for its turn may return to the LiveKit room. Pure. */
export function mayGo(room: RoomState, me: ViewerInfo): boolean {
  if (mustCome(room, me)) return false;
  return me.role === "observer" || me.wait_s === null || me.wait_s > LEAVES_S;
}

/** The room state with this viewer added: broadcasts leave out those who only watch. Pure. */
export function withMe(room: RoomState, id: number, name: string): RoomState {
  if (room.viewers.some((one) => one.id === id)) return room;
  const me: ViewerInfo = {
    id,
    name,
    role: "observer",
    place: null,
    wait_s: null,
    lost: false,
    host: false,
  };
  return { ...room, viewers: [...room.viewers, me] };
}
