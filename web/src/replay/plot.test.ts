import { expect, it } from "vitest";
import { scaleFor, steps, xOf } from "./plot";

const BOX = { fromMs: 0, toMs: 1000, least: 0, most: 10, width: 100, height: 50 };

it("holds each value until the next", () => {
  const line = steps(
    [
      { atMs: 0, value: 10 },
      { atMs: 500, value: 5 },
    ],
    BOX,
  );
  expect(line).toBe("M0 0H50V25H100");
});

it("breaks at unknown values", () => {
  const line = steps(
    [
      { atMs: 0, value: null },
      { atMs: 200, value: 0 },
      { atMs: 400, value: null },
      { atMs: 600, value: 10 },
    ],
    BOX,
  );
  expect(line).toBe("M20 50H40M60 0H100");
});

it("cuts values beyond the box at its edge", () => {
  expect(steps([{ atMs: -5, value: 99 }], BOX)).toBe("M0 0H100");
  expect(xOf(2000, BOX)).toBe(100);
  expect(steps([], BOX)).toBe("");
});

it("scales to a round number above all values", () => {
  expect(scaleFor([120, null, 80], 100)).toBe(200);
  expect(scaleFor([], 100)).toBe(100);
  expect(scaleFor([-0.6], 0.1)).toBe(1);
});
