import { expect, it } from "vitest";
import { deflectionAt, motionOf } from "./stick";

const PLACE = { x: 100, y: 200, radius: 50 };

it.each([
  ["the middle", 100, 200, 0, 0],
  ["half way to the right", 125, 200, 0.5, 0],
  ["the upper rim", 100, 150, 0, -1],
])("knows %s", (_, x, y, right, down) => {
  expect(deflectionAt(PLACE, x, y)).toEqual({ x: right, y: down });
});

it("stays on the rim while the finger goes beyond, in its direction", () => {
  const { x, y } = deflectionAt(PLACE, 400, -200);
  expect(Math.hypot(x, y)).toBeCloseTo(1, 10);
  expect(y / x).toBeCloseTo(-4 / 3, 10);
});

it.each([
  ["up", { x: 0, y: -1 }, { linear: 1, angular: 0 }],
  ["down", { x: 0, y: 1 }, { linear: -1, angular: 0 }],
  ["left", { x: -1, y: 0 }, { linear: 0, angular: 1 }],
  ["right", { x: 1, y: 0 }, { linear: 0, angular: -1 }],
  ["nowhere", { x: 0.05, y: 0.05 }, { linear: 0, angular: 0 }],
])("%s is a motion", (_, deflection, motion) => {
  expect(motionOf(deflection)).toEqual(motion);
});

it("moves in all directions by one stick, and turns by the other, which goes only sideways", () => {
  expect(motionOf({ x: -1, y: 0 }, "move")).toEqual({ linear: 0, angular: 0, lateral: 1 });
  const { linear, lateral = 0 } = motionOf(deflectionAt(PLACE, 400, -100), "move");
  expect(Math.hypot(linear, lateral)).toBeCloseTo(1, 10);
  const turned = deflectionAt(PLACE, PLACE.x - PLACE.radius, 150, "turn");
  expect(turned).toEqual({ x: -1, y: 0 });
  expect(motionOf(turned, "turn")).toEqual({ linear: 0, angular: 1 });
});

it("is proportional: the further, the faster", () => {
  const speeds = [0.2, 0.5, 0.8].map((y) => motionOf({ x: 0, y: -y }).linear);
  expect(speeds).toEqual([...speeds].sort());
  expect(new Set(speeds).size).toBe(3);
  expect(Math.max(...speeds)).toBeLessThan(1);
});
