import { expect, it } from "vitest";
import { DelayMeter } from "./meanDelay";

it("divides the added delay by the number of items since the last call", () => {
  const meter = new DelayMeter();
  expect(meter.next(100, 1000)).toBeNull();
  expect(meter.next(101, 1020)).toBeCloseTo(50);
});

it("reports nothing without items, or if the browser does not count", () => {
  const meter = new DelayMeter();
  meter.next(1, 10);
  expect(meter.next(1, 10)).toBeNull();
  expect(meter.next(undefined, undefined)).toBeNull();
});
