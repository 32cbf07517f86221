import { expect, it } from "vitest";
import type { RobotStatus } from "../messages";
import { room } from "../testing/messages";
import { numbersNamed } from "./robotNumbers";

it("shows what the robot reports of its battery, the charge first", () => {
  const { robot } = room({});
  const battery = (now: RobotStatus) => numbersNamed("facts.battery", now);
  expect(battery(robot)).toEqual([]);
  expect(battery({ ...robot, battery_v: 7.4 })).toEqual(["7.4 V"]);
  expect(battery({ ...robot, battery_v: 12, battery_fraction: 0.615 })).toEqual(["62 %", "12.0 V"]);
});
