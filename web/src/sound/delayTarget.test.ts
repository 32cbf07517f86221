import { expect, it } from "vitest";
import { DelayTarget } from "./delayTarget";

const MS = 48;
const S = 1000 * MS;

/** Adds a packet every 20 ms that is late by `lateMs` of its time; returns the target in ms. */
function after(
  seconds: number,
  lateMs: (ms: number) => number,
  target = new DelayTarget(),
): number {
  for (let ms = 0; ms < seconds * 1000; ms += 20) target.add(lateMs(ms) * MS, ms * MS);
  return target.at(seconds * S) / MS;
}

it("is just above the delay of all packets", () => {
  expect(after(10, () => 30)).toBeCloseTo(31.5);
});

it("covers the latest packets if they are hardly later than the others", () => {
  expect(after(10, (ms) => (ms % 4000 === 0 ? 38 : 30))).toBeCloseTo(39.5);
});

it("does not wait for a few that are much later", () => {
  expect(after(10, (ms) => (ms % 4000 === 0 ? 300 : 30))).toBeCloseTo(41.5);
});

it("forgets old packets", () => {
  expect(after(20, (ms) => (ms < 11_000 ? 200 : 30))).toBeCloseTo(31.5);
});

it("forgets the first packets sooner", () => {
  expect(after(3, (ms) => (ms < 1000 ? 800 : 30))).toBeLessThan(45);
});

it("never exceeds half a second", () => {
  expect(after(10, (ms) => (ms % 1000 < 500 ? 3000 : 30))).toBe(530);
});

it("starts over after `clear`", () => {
  const target = new DelayTarget();
  after(10, () => 500, target);
  target.clear();
  target.add(30 * MS, 11 * S);
  expect(target.at(11 * S) / MS).toBeCloseTo(31.5);
});
