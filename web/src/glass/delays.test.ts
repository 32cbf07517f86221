import { expect, it } from "vitest";
import { REPEATS_MS } from "./code";
import { ageOf, delaysOf, type Sight, withSight } from "./delays";

it("tells a code's age over its repetition, and a clock that cannot be right", () => {
  expect(ageOf(1000, 1040)).toBe(40);
  expect(ageOf(REPEATS_MS - 20, 5 * REPEATS_MS + 100)).toBe(120);
  expect(ageOf(50, REPEATS_MS + 45)).toBe(-5);
  expect(ageOf(50, 45)).toBe(-5);
  expect(ageOf(0, 9_000)).toBe(9_000);
  expect(ageOf(0, 11_000)).toBeNull();
  expect(ageOf(3_000, 1_000)).toBeNull();
});

it("says what half and 95 % of the pictures are below, and the part that is not WAX's", () => {
  expect(delaysOf([])).toBeNull();
  const sights = Array.from({ length: 100 }, (_, at) => ({ totalMs: 100 + at, knownMs: 60 + at }));
  expect(delaysOf(sights)).toEqual({ count: 100, p50Ms: 149, p95Ms: 194, restMs: 40 });
  expect(delaysOf([{ totalMs: 90, knownMs: null }])).toMatchObject({ p50Ms: 90, restMs: null });
});

it("forgets what is long past", () => {
  let sights: Sight[] = [];
  for (let ms = 0; ms < 2000; ms++) sights = withSight(sights, { totalMs: ms, knownMs: null });
  expect(delaysOf(sights)).toMatchObject({ count: 600, p50Ms: 1699 });
});
