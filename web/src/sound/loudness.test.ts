import { expect, it } from "vitest";
import { LevelMeter, levelOfPower } from "./loudness";

const block = (amplitude: number) => new Float32Array(128).fill(amplitude);

it("shows loudness in even steps", () => {
  expect([levelOfPower(0), levelOfPower(1), levelOfPower(1e-12)]).toEqual([0, 1, 0]);
  expect(levelOfPower(0.01)).toBeCloseTo(2 / 3);
});

it("measures each ear, since the last look", () => {
  const meter = new LevelMeter();
  meter.add([block(1), block(0.1)]);
  meter.add([block(1), block(0.1)]);
  const [left, right] = meter.take();
  expect(left).toBeCloseTo(1);
  expect(right).toBeCloseTo(2 / 3);
  expect(meter.take()).toEqual([0, 0]);
  meter.add([block(0), block(1)]);
  expect(meter.take()).toEqual([0, 1]);
});
