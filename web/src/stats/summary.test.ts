import { expect, it } from "vitest";
import { median, summary } from "./summary";

it("gives minimum, maximum, median and newest of the known values", () => {
  expect(summary([5, null, 1, 9, 2, null])).toEqual({ least: 1, median: 3.5, most: 9, newest: 2 });
  expect(summary([-4])).toEqual({ least: -4, median: -4, most: -4, newest: -4 });
});

it("is null without values", () => {
  expect(summary([])).toBeNull();
  expect(summary([null, null])).toBeNull();
  expect(median([])).toBeNull();
});

it("finds the middle of an odd number of values", () => {
  expect(median([9, 1, 5])).toBe(5);
});
