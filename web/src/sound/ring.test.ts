import { expect, it } from "vitest";
import { Ring } from "./ring";

const SECONDS = 48_000;
const ramp = (from: number, count: number) =>
  Float32Array.from({ length: count }, (_, i) => from + i);

it("returns what was written, and silence elsewhere", () => {
  const ring = new Ring();
  ring.write(240, ramp(240, 240));
  expect([239, 240, 479, 480].map((time) => ring.at(time, 0))).toEqual([0, 240, 479, 0]);
  expect([ring.has(240, 480), ring.has(239, 480), ring.has(240, 481)]).toEqual([
    true,
    false,
    false,
  ]);
  expect(ring.end).toBe(480);
});

it("forgets sound after three seconds", () => {
  const ring = new Ring();
  ring.write(0, ramp(1, 120));
  ring.write(3 * SECONDS, ramp(7, 120));
  expect(ring.at(0, 0)).toBe(0);
  expect(ring.at(3 * SECONDS, 0)).toBe(7);
});

it("keeps the ears apart", () => {
  const ring = new Ring();
  ring.write(120, ramp(120, 120), ramp(1000, 120));
  expect([ring.at(130, 0), ring.at(130, 1)]).toEqual([130, 1010]);
  ring.write(240, ramp(240, 120));
  expect([ring.at(250, 0), ring.at(250, 1)]).toEqual([250, 250]);
});

it("interpolates a straight line exactly", () => {
  const ring = new Ring();
  ring.write(0, ramp(0, 480));
  expect(ring.between(200.25, 1)).toBeCloseTo(200.25);
});

it("finds where the sound continues", () => {
  const ring = new Ring();
  ring.write(0, ramp(0, 120));
  ring.write(480, ramp(480, 120));
  expect([ring.nextFrom(7), ring.nextFrom(120), ring.nextFrom(600)]).toEqual([7, 480, 600]);
});

it("is empty once it is cleared", () => {
  const ring = new Ring();
  ring.write(0, ramp(1, 480));
  ring.clear();
  expect([ring.end, ring.at(3, 0), ring.has(0, 1)]).toEqual([0, 0, false]);
});
