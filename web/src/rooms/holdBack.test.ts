import { expect, it } from "vitest";
import { HoldBack } from "./holdBack";

/**
 * Reports every 250 ms of a picture that without being held is younger by so much; what it is held
 * by moves as browsers move it, 100 ms a second. Returns what it was held by at the end.
 */
function play(hold: HoldBack, youngerMs: (i: number) => number, reports = 80): number[] {
  let actualMs = 0;
  const held: number[] = [];
  for (let i = 0; i < reports; i++) {
    actualMs += Math.min(Math.max(hold.heldMs - actualMs, -25), 25);
    hold.add(youngerMs(i) - actualMs, i * 250);
    held.push(hold.heldMs);
  }
  return held;
}

it.each([0, 5, 60, 180, 500])("holds the picture back until its sound is heard: %i ms", (ms) => {
  const held = play(new HoldBack(), () => ms);
  expect(Math.abs((held.at(-1) ?? Number.NaN) - ms)).toBeLessThanOrEqual(8);
});

it("does not overshoot, although a change takes time", () => {
  expect(Math.max(...play(new HoldBack(), () => 300))).toBeLessThanOrEqual(310);
});

it("is not moved by single measurements", () => {
  const held = play(new HoldBack(), (i) => (i % 4 === 0 ? 200 : 60));
  for (const ms of held.slice(20)) expect(ms).toBe(60);
});

it("never delays a late picture, and never waits more than half a second", () => {
  expect(play(new HoldBack(), () => -100).at(-1)).toBe(0);
  expect(play(new HoldBack(), () => 600).at(-1)).toBe(500);
});

it("does not wait for sound that would still be too late", () => {
  expect(play(new HoldBack(), () => 900).at(-1)).toBe(0);
});

it("follows the sound down again", () => {
  const held = play(new HoldBack(), (i) => (i < 40 ? 200 : 50), 120);
  expect(held[39]).toBe(200);
  expect(held.at(-1)).toBe(50);
});

it("holds a new buffer back by as much, and measures it once it is filled", () => {
  const hold = new HoldBack();
  play(hold, () => 200);
  hold.restart(100_000);
  for (let i = 0; i < 10; i++) hold.add(200, 100_000 + i * 250);
  expect(hold.heldMs).toBe(200);
  hold.forget();
  expect(hold.heldMs).toBe(0);
});
