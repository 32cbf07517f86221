import { expect, it } from "vitest";
import { LastMinute } from "./breaks";

it("counts the breaks of the last minute and knows the longest", () => {
  const breaks = new LastMinute(30);
  expect(breaks.summarize(0)).toEqual({ count: 0, longestMs: 0 });
  breaks.add(1000, 1, 200);
  breaks.add(2000, 1, 80);
  breaks.add(2250, 0, 0);
  expect(breaks.summarize(3000)).toEqual({ count: 2, longestMs: 200 });
  expect(breaks.summarize(61_500)).toEqual({ count: 1, longestMs: 80 });
  expect(breaks.summarize(63_000)).toEqual({ count: 0, longestMs: 0 });
});

it("counts a break across several samples once", () => {
  const breaks = new LastMinute(30);
  breaks.add(250, 1, 20);
  breaks.add(500, 0, 250);
  breaks.add(750, 0, 100);
  expect(breaks.summarize(800)).toEqual({ count: 1, longestMs: 370 });
});

it("does not merge several short ones into a long one", () => {
  const breaks = new LastMinute(30);
  breaks.add(250, 3, 60);
  expect(breaks.summarize(300)).toEqual({ count: 0, longestMs: 0 });
  breaks.add(500, 2, 120);
  expect(breaks.summarize(600)).toEqual({ count: 2, longestMs: 60 });
});
