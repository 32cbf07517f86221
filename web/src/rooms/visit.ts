import type { RoomState, ViewerInfo } from "../messages";

/** The page connects to the robot's server ten seconds before its turn; it is told once a second. */
const CONNECTS_S = 11;
/** Who has to wait for longer than this need not be there; more than above, against to and fro. */
const LEAVES_S = 20;

/** Whether this viewer's turn is so near that the page must be at the robot's own server. Pure. */
export function mustCome(room: RoomState, me: ViewerInfo): boolean {
  if (me.role === "operator" || room.call?.viewer === me.id) return true;
  if (me.role !== "queued") return false;
  // Nobody knows when it begins: then it may begin now.
  if (me.wait_s === null) return me.place === 1;
  return me.wait_s <= CONNECTS_S;
}

/** Whether a page that came for its turn is not needed there any more. Pure. */
export function mayGo(room: RoomState, me: ViewerInfo): boolean {
  if (mustCome(room, me)) return false;
  return me.role === "observer" || me.wait_s === null || me.wait_s > LEAVES_S;
}

/** The room as this page shows it; messages to everybody leave out who only watches. Pure. */
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
