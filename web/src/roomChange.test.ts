import { expect, it } from "vitest";
import type { RoomChange } from "./messages";
import { changed } from "./roomChange";
import { pressedBy, room, turn, viewer } from "./testing/messages";

const before = room({ operator: 1, waiting: [2], watching: [3] });

function change(more: Partial<RoomChange>): RoomChange {
  return { ...before, type: "room_change", viewers: [], gone: [], ...more };
}

it("keeps unchanged viewers and replaces changed ones in place", () => {
  const after = changed(before, change({ viewers: [viewer(3, { name: "Zoë" })] }));
  expect(after.viewers.map((line) => line.name)).toEqual(["Ada", "Bob", "Zoë"]);
  expect(after.viewers[1]?.place).toBe(1);
});

it("adds new viewers in the order of arrival, and removes those who left", () => {
  const after = changed(before, change({ viewers: [viewer(4)], gone: [2] }));
  expect(after.viewers.map((line) => line.id)).toEqual([1, 3, 4]);
});

it("takes everything else from the change, a released stop too", () => {
  const stopped = { ...before, stop: pressedBy("Bob", { number: 4 }) };
  const next = turn({ number: 9, operator: 3 });
  const after = changed(stopped, change({ turn: next, stop: null }));
  expect(after).toEqual({ ...before, turn: next, viewers: changed(before, change({})).viewers });
  expect(after).not.toHaveProperty("gone");
});
