import { describe, expect, it } from "vitest";
import { attemptAfterMs, freshMs, patienceMs } from "./reconnect";

/** When each attempt begins, in ms after the loss. */
function beginnings(count: number, random: number): number[] {
  let atMs = 0;
  return Array.from({ length: count }, (_, attempt) => {
    atMs += attemptAfterMs(attempt, random);
    return Math.round(atMs);
  });
}

describe("attempts", () => {
  it("begin at once, several times in the first seconds, then every second for 20 s", () => {
    const all = beginnings(27, 0.5);
    expect(all.slice(0, 9)).toEqual([0, 300, 700, 1100, 1500, 1900, 2300, 3300, 4300]);
    expect(all.at(-1)).toBe(22_300);
  });

  it("then become rarer, but at least every ten seconds", () => {
    const later = Array.from({ length: 20 }, (_, i) => attemptAfterMs(27 + i, 1));
    expect(later).toEqual(later.toSorted((a, b) => a - b));
    expect(later[0]).toBeGreaterThan(1200);
    expect(later.at(-1)).toBeLessThanOrEqual(10_000);
  });

  it("have pauses that vary at random by a fifth either way", () => {
    for (const [random, share] of [
      [0, 0.8],
      [1, 1.2],
    ] as const) {
      expect(attemptAfterMs(0, random)).toBe(0);
      expect(attemptAfterMs(7, random)).toBeCloseTo(1000 * share);
    }
  });
});

describe("an attempt", () => {
  it("ends when the next begins if the link was fast", () => {
    expect(patienceMs(1000, { roundTripMs: 0, isThin: false })).toBe(1000);
  });

  it("may take three round trips more if they are long", () => {
    expect(patienceMs(1000, { roundTripMs: 800, isThin: false })).toBe(3400);
  });

  it("may take ten seconds if the link was slow or is unknown", () => {
    expect(patienceMs(300, { roundTripMs: 300, isThin: true })).toBe(10_000);
    expect(patienceMs(300, null)).toBe(10_000);
  });

  it("is not restarted for as long if the link was slow", () => {
    expect(freshMs(true)).toBe(10_000);
    expect(freshMs(false)).toBe(250);
  });
});
