import { expect, it } from "vitest";
import { shaped, shapedAxis } from "./deflection";

const EVEN = { deadZone: 0.2, curve: 1 };

it.each([
  [0, 0],
  [0.2, 0],
  [-0.2, 0],
  [0.6, 0.5],
  [-0.6, -0.5],
  [1, 1],
  [-1.4, -1],
  [Number.NaN, 0],
])("answers %d with %d: nothing in the dead zone, all at the end", (value, answer) => {
  expect(shapedAxis(value, EVEN)).toBeCloseTo(answer, 10);
});

it("is gentler near the middle the larger the curve", () => {
  expect(shapedAxis(0.6, { deadZone: 0.2, curve: 2 })).toBeCloseTo(0.25, 10);
  expect(shapedAxis(1, { deadZone: 0.2, curve: 3 })).toBe(1);
});

it("keeps a stick's direction, and cuts the corners of a square one", () => {
  const { x, y } = shaped({ x: 0.3, y: -0.4 }, EVEN);
  expect(y / x).toBeCloseTo(-4 / 3, 10);
  expect(Math.hypot(x, y)).toBeCloseTo(0.375, 10);
  const corner = shaped({ x: 1, y: 1 }, EVEN);
  expect(Math.hypot(corner.x, corner.y)).toBeCloseTo(1, 10);
});

it("counts a centred stick, or NaN, as released", () => {
  expect(shaped({ x: 0.1, y: -0.1 }, EVEN)).toEqual({ x: 0, y: 0 });
  expect(shaped({ x: Number.NaN, y: 1 }, EVEN)).toEqual({ x: 0, y: 0 });
});
