import { expect, it } from "vitest";
import type { RoomState, ViewerInfo } from "../messages";
import { room, viewer } from "../testing/messages";
import { mayGo, mustCome, withMe } from "./visit";

function waiting(wait_s: number | null, place = 2): ViewerInfo {
  return viewer(1, { role: "queued", place, wait_s });
}

function called(id: number): RoomState {
  return { ...room({ operator: 2 }), call: { viewer: id, until_server_ms: 0 } };
}

const now = room({ operator: 2, waiting: [1] });

it.each([
  ["its turn in 10 s", now, waiting(10), true],
  ["its turn in 10 s, told a second ago", now, waiting(11), true],
  ["its turn in 12 s", now, waiting(12), false],
  ["its turn at a time that nobody knows", now, waiting(null, 1), true],
  ["a later turn at a time that nobody knows", now, waiting(null, 2), false],
  ["its turn", now, viewer(1, { role: "operator", place: 0, wait_s: 0 }), true],
  ["a question whether it is there", called(1), waiting(60), true],
  ["such a question to another", called(3), waiting(60), false],
  ["no wish to drive", now, viewer(1), false],
])("a page with %s is at the robot's server: %#", (_, state, me, must) => {
  expect(mustCome(state, me)).toBe(must);
});

it.each([
  ["its turn is over", viewer(1), true],
  ["it waits for a minute again", waiting(60), true],
  ["it waits for a little longer than it had to come for", waiting(15), false],
  ["it drives", viewer(1, { role: "operator" }), false],
])("and goes when %s: %#", (_, me, may) => {
  expect(mayGo(now, me)).toBe(may);
});

it("lists this page among the observers, once", () => {
  const mine = withMe(now, 0, "Ada");
  expect(mine.viewers.at(-1)).toEqual(viewer(0, { name: "Ada" }));
  expect(mine.viewers).toHaveLength(3);
  expect(withMe(now, 1, "Ada")).toBe(now);
});
