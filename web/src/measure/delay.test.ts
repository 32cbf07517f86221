import { expect, it } from "vitest";
import { DelayMeter } from "./delay";

it("divides what was added to the delay by what came out since", () => {
  const meter = new DelayMeter();
  expect(meter.next({ jitterBufferDelay: 100, jitterBufferEmittedCount: 1000 })).toBeNull();
  expect(meter.next({ jitterBufferDelay: 101, jitterBufferEmittedCount: 1020 })).toBeCloseTo(50);
});

it("tells nothing when nothing came out, or where the browser does not count", () => {
  const meter = new DelayMeter();
  meter.next({ jitterBufferDelay: 1, jitterBufferEmittedCount: 10 });
  expect(meter.next({ jitterBufferDelay: 1, jitterBufferEmittedCount: 10 })).toBeNull();
  expect(meter.next({})).toBeNull();
});
