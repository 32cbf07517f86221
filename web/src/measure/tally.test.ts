import { expect, it } from "vitest";
import { Tally } from "./tally";

it("sums the counters' increases", () => {
  const tally = new Tally("bad", "all");
  tally.add(5, { bad: 2, all: 100 });
  expect(tally.add(6, { bad: 5, all: 150 })).toEqual({ bad: 3, all: 50 });
  expect(tally.add(7, { bad: 5, all: 190 })).toEqual({ bad: 0, all: 40 });
  expect(tally.total).toEqual({ bad: 3, all: 90 });
});

it("starts with the first arrival, without what was counted while waiting for it", () => {
  const tally = new Tally("bad");
  tally.add(0, { bad: 10 });
  tally.add(0, { bad: 500 });
  tally.add(1, { bad: 600 });
  tally.add(2, { bad: 601 });
  expect(tally.total).toEqual({ bad: 1 });
});

it("leaves out the time in which the stream was off, until something arrives again", () => {
  const tally = new Tally("bad");
  tally.add(1, { bad: 0 });
  tally.add(2, { bad: 4 });
  tally.rest();
  tally.add(2, { bad: 1000 });
  tally.add(2, { bad: 1300 });
  tally.add(3, { bad: 1400 });
  tally.add(4, { bad: 1402 });
  expect(tally.total).toEqual({ bad: 6 });
});

it("never falls, whatever a browser counts", () => {
  const tally = new Tally("bad");
  tally.add(1, { bad: 7 });
  expect(tally.add(2, { bad: 3 })).toEqual({ bad: 0 });
  expect(tally.total).toEqual({ bad: 0 });
});
