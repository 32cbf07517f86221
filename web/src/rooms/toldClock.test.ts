import { expect, it } from "vitest";
import { ToldClock } from "./toldClock";

it("knows nothing before the first message", () => {
  expect(new ToldClock().toServerMs(5)).toBeNull();
});

it("trusts the fastest message for twenty seconds", () => {
  const clock = new ToldClock();
  for (const [i, tookMs] of [400, 30, 900].entries()) {
    clock.add(5000 + i * 1000, i * 1000 + tookMs);
  }
  expect(clock.toServerMs(3000)).toBe(7970);
  clock.add(30_000, 25_900);
  expect(clock.toServerMs(26_000)).toBe(30_100);
});
