import { expect, it } from "vitest";
import { room, viewer } from "../testing/messages";
import { clockWords, isOnlyHere, joinAddress, wantsSound, watchers } from "./facts";

it("counts observers and the queue, but neither the operator nor the screen itself", () => {
  const now = room({ operator: 1, waiting: [2], watching: [3, 4] });
  expect(watchers(now, 4, null)).toBe(2);
  const lost = { ...now, viewers: [...now.viewers, viewer(5, { lost: true })] };
  expect(watchers(lost, 4, null)).toBe(2);
  expect(watchers(now, 4, 1200)).toBe(1200);
});

it("writes the time left as a clock", () => {
  expect([0, 7, 60, 95].map(clockWords)).toEqual(["0:00", "0:07", "1:00", "1:35"]);
});

it("sends people to the page, not to the big screen's view", () => {
  const at = new URL("https://robot.example.org/here/?view=big-screen&sound=on#x");
  expect(joinAddress(at)).toBe("https://robot.example.org/here/");
});

it.each([
  ["localhost", true],
  ["127.0.0.1", true],
  ["[::1]", true],
  ["wax.localhost", true],
  ["192.168.1.7", false],
  ["robot.example.org", false],
  ["localhost.example.org", false],
])("knows whether phones can open %s", (hostname, isOnly) => {
  expect(isOnlyHere(hostname)).toBe(isOnly);
});

it("has sound only if the address asks for it", () => {
  expect(wantsSound("?view=big-screen")).toBe(false);
  expect(wantsSound("?view=big-screen&sound=on")).toBe(true);
});
