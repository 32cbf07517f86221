import { expect, it } from "vitest";
import { Arrivals } from "./arrivals";

it("counts what arrives in a second", () => {
  const arrivals = new Arrivals();
  expect(arrivals.next(100, 1000)).toBeNull();
  expect(arrivals.next(115, 1500)).toBe(30);
  expect(arrivals.next(115, 2500)).toBe(0);
});

it("reports nothing if the counter restarts, is missing, or no time has passed", () => {
  const arrivals = new Arrivals();
  arrivals.next(100, 1000);
  expect(arrivals.next(3, 2000)).toBeNull();
  expect(arrivals.next(undefined, 3000)).toBeNull();
  expect(arrivals.next(9, 4000)).toBeNull();
  expect(arrivals.next(12, 4000)).toBeNull();
});
