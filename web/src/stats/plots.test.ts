import { expect, it } from "vitest";
import { sample } from "../testing/samples";
import { History } from "./history";
import { clockWords, PLOTS, scaleOf, secondsOf, spanOf, valuesOf } from "./plots";

it("plots bit rates in kbit/s, and gaps as gaps", () => {
  const history = new History();
  history.add(sample(1000, { linkBps: 180_000 }));
  history.add(sample(2000));
  const line = PLOTS.flatMap((plot) => plot.lines).find((one) => one.field === "linkBps");
  expect(line && valuesOf(history, line)).toEqual([180, null]);
  expect(secondsOf(history, 4000)).toEqual([-3, -2]);
});

it("shows the whole past, at least a minute", () => {
  expect(spanOf([])).toEqual([-60, 0]);
  expect(spanOf([-4, -1])).toEqual([-60, 0]);
  expect(spanOf([-400, -1])).toEqual([-400, 0]);
});

it("does not make a small change look large", () => {
  expect(scaleOf(2, 3, false)).toEqual([0, 10]);
  expect(scaleOf(20, 100, false)[0]).toBe(0);
  expect(scaleOf(20, 100, false)[1]).toBeCloseTo(110);
  expect(scaleOf(-100, 5, true)[0]).toBeCloseTo(-110);
  expect(scaleOf(1, 5, true)).toEqual([-10, 10]);
});

it("writes times as a clock does", () => {
  expect([-90, -5, 0].map(clockWords)).toEqual(["1:30", "0:05", "0:00"]);
});
