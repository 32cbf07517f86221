import { expect, it } from "vitest";
import { Silence } from "./silence";

const RTT_MS = 20;

/** Checks every `everyMs` for `forMs`; returns the time at the end. */
function lookOn(silence: Silence, fromMs: number, forMs: number, everyMs: number): number {
  for (let ms = everyMs; ms <= forMs; ms += everyMs) silence.update(fromMs + ms);
  return fromMs + forMs;
}

it("is doubtful after 300 ms without a message, not before", () => {
  const silence = new Silence(1000);
  lookOn(silence, 1000, 290, 10);
  expect(silence.isDoubtful).toBe(false);
  silence.update(1300);
  expect(silence.isDoubtful).toBe(true);
  silence.heard(1310);
  expect(silence.isDoubtful).toBe(false);
  expect(silence.sinceMs).toBe(1310);
});

it("is silent after 700 ms, if a ping had time to be answered", () => {
  const silence = new Silence(0);
  lookOn(silence, 0, 690, 10);
  expect(silence.isSilent(1e6, RTT_MS, false)).toBe(false);
  silence.update(700);
  expect(silence.isSilent(1e6, RTT_MS, false)).toBe(true);
  expect(silence.isSilent(319, RTT_MS, false)).toBe(false);
  expect(silence.isSilent(320, RTT_MS, false)).toBe(true);
});

it("is silent later over a slow link, which may stall for a second", () => {
  const silence = new Silence(0);
  lookOn(silence, 0, 1490, 10);
  expect(silence.isSilent(1e6, RTT_MS, true)).toBe(false);
  silence.update(1500);
  expect(silence.isSilent(1e6, RTT_MS, true)).toBe(true);
});

it("does not count time in which the page did not run", () => {
  const silence = new Silence(0);
  silence.update(60_000);
  expect(silence.isDoubtful).toBe(false);
  lookOn(silence, 60_000, 490, 10);
  expect(silence.isSilent(1e6, RTT_MS, false)).toBe(false);
  silence.update(60_500);
  expect(silence.isSilent(1e6, RTT_MS, false)).toBe(true);
});

it("is not silent in a hidden tab that checks and receives once a second", () => {
  const silence = new Silence(0);
  for (let ms = 1000; ms < 60_000; ms += 1000) {
    silence.update(ms);
    expect(silence.isDoubtful).toBe(false);
    silence.heard(ms + 10);
  }
});
