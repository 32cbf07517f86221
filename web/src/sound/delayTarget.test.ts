import { expect, it } from "vitest";
import { DelayTarget } from "./delayTarget";

const MS = 48;
const S = 1000 * MS;

/** Adds a packet each 20 ms that is late by `lateMs` of its time; returns the target, in ms. */
function after(
  seconds: number,
  lateMs: (ms: number) => number,
  target = new DelayTarget(),
): number {
  for (let ms = 0; ms < seconds * 1000; ms += 20) target.add(lateMs(ms) * MS, ms * MS);
  return target.at(seconds * S) / MS;
}

it("is just above what all packets take", () => {
  expect(after(10, () => 30)).toBeCloseTo(31.5);
});

it("covers the latest where they are hardly later than the others", () => {
  expect(after(10, (ms) => (ms % 4000 === 0 ? 38 : 30))).toBeCloseTo(39.5);
});

it("does not wait for a few that are much later", () => {
  expect(after(10, (ms) => (ms % 4000 === 0 ? 300 : 30))).toBeCloseTo(41.5);
});

it("forgets what was long ago", () => {
  expect(after(20, (ms) => (ms < 11_000 ? 200 : 30))).toBeCloseTo(31.5);
});

it("forgets the beginning sooner", () => {
  expect(after(3, (ms) => (ms < 1000 ? 800 : 30))).toBeLessThan(45);
});

it("waits for nobody longer than half a second", () => {
  expect(after(10, (ms) => (ms % 1000 < 500 ? 3000 : 30))).toBe(530);
});

it("knows nothing once it is cleared", () => {
  const target = new DelayTarget();
  after(10, () => 500, target);
  target.clear();
  target.add(30 * MS, 11 * S);
  expect(target.at(11 * S) / MS).toBeCloseTo(31.5);
});
