import { expect, it } from "vitest";
import { Freezes } from "./freezes";

/** Presents pictures with these gaps in ms. */
function shown(...gapsMs: number[]): Freezes {
  const freezes = new Freezes();
  let atMs = 1000;
  freezes.presented(atMs);
  for (const gapMs of gapsMs) {
    atMs += gapMs;
    freezes.presented(atMs);
  }
  return freezes;
}

const steady = (gapMs: number) => Array.from({ length: 30 }, () => gapMs);

it("counts a gap longer than the mean plus 150 ms and than three times the mean", () => {
  expect(shown(...steady(40), 189)).toMatchObject({ count: 0, totalMs: 0 });
  expect(shown(...steady(40), 191)).toMatchObject({ count: 1, totalMs: 191 });
  expect(shown(...steady(200), 599).count).toBe(0);
  expect(shown(...steady(200), 601).count).toBe(1);
});

it("counts no freeze before it knows the rate", () => {
  expect(shown(5000).count).toBe(0);
});

it("does not count pauses", () => {
  const freezes = shown(...steady(40));
  freezes.rest();
  freezes.presented(60_000);
  expect(freezes.count).toBe(0);
  freezes.presented(60_900);
  expect(freezes).toMatchObject({ count: 1, totalMs: 900 });
});

it("ignores a picture that is reported too late", () => {
  const freezes = shown(...steady(40));
  freezes.presented(1100);
  freezes.presented(2240);
  expect(freezes.count).toBe(0);
});
