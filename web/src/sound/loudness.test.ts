import { expect, it } from "vitest";
import { LevelMeter, levelOfPower } from "./loudness";

const block = (amplitude: number, offset = 0) =>
  new Float32Array(128).map((_, at) => offset + (at % 2 ? amplitude : -amplitude));

it("is linear in dB", () => {
  expect([levelOfPower(0), levelOfPower(1), levelOfPower(1e-12)]).toEqual([0, 1, 0]);
  expect(levelOfPower(0.01)).toBeCloseTo(2 / 3);
});

it("measures each ear since the last reading", () => {
  const meter = new LevelMeter();
  meter.add([block(1), block(0.1)]);
  meter.add([block(1), block(0.1)]);
  const [left, right] = meter.flush();
  expect(left).toBeCloseTo(1);
  expect(right).toBeCloseTo(2 / 3);
  expect(meter.flush()).toEqual([0, 0]);
  meter.add([block(0), block(1)]);
  expect(meter.flush()).toEqual([0, 1]);
});

it("ignores a microphone's DC offset", () => {
  const meter = new LevelMeter();
  meter.add([block(0, 0.25), block(0.1, -0.25)]);
  const [left, right] = meter.flush();
  expect(left).toBe(0);
  expect(right).toBeCloseTo(2 / 3);
});
