import { expect, it } from "vitest";
import { delayLevel } from "./Hud";

it("colours the delay by the robot's limit, and an unknown one is not good", () => {
  expect(delayLevel(200, 400)).toBe("good");
  expect(delayLevel(201, 400)).toBe("fair");
  expect(delayLevel(400, 400)).toBe("fair");
  expect(delayLevel(401, 400)).toBe("poor");
  expect(delayLevel(null, 400)).toBe("fair");
});
