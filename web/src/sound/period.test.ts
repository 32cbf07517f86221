import { expect, it } from "vitest";
import { periodBefore } from "./period";

it.each([100, 150, 220, 300, 390])("finds the period of a voice at %i Hz", (hz) => {
  const voice = (time: number) =>
    Math.sin((2 * Math.PI * hz * time) / 48_000) + Math.sin((4 * Math.PI * hz * time) / 48_000);
  const period = periodBefore(voice, 5000);
  const turns = (period * hz) / 48_000;
  expect(Math.abs(turns - Math.round(turns))).toBeLessThan(0.03);
});

it("returns some length for silence", () => {
  expect(periodBefore(() => 0, 5000)).toBeGreaterThan(0);
});
