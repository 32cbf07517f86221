import { expect, it } from "vitest";
import { photoName } from "./snapshot";

const AT = new Date(2026, 4, 3, 9, 5, 7);

it.each([
  ["Marvin", "marvin-2026-05-03-09-05-07.png"],
  ["Der Staubsauger: Nr. 2!", "der-staubsauger-nr-2-2026-05-03-09-05-07.png"],
  ["ロボット", "ロボット-2026-05-03-09-05-07.png"],
  ["../../etc/passwd", "etc-passwd-2026-05-03-09-05-07.png"],
  ["…", "robot-2026-05-03-09-05-07.png"],
  ["", "robot-2026-05-03-09-05-07.png"],
])("names a photo of %j so that any computer can keep it", (robot, name) => {
  expect(photoName(robot, AT)).toBe(name);
});

it("cuts a name that is too long", () => {
  expect(photoName("x".repeat(500), AT).length).toBeLessThan(70);
});
