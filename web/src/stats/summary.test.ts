import { expect, it } from "vitest";
import { median, summary } from "./summary";

it("says how little, how much, the middle and the newest, whatever is unknown", () => {
  expect(summary([5, null, 1, 9, 2, null])).toEqual({ least: 1, median: 3.5, most: 9, newest: 2 });
  expect(summary([-4])).toEqual({ least: -4, median: -4, most: -4, newest: -4 });
});

it("says nothing about nothing", () => {
  expect(summary([])).toBeNull();
  expect(summary([null, null])).toBeNull();
  expect(median([])).toBeNull();
});

it("finds the middle one of an odd number", () => {
  expect(median([9, 1, 5])).toBe(5);
});
