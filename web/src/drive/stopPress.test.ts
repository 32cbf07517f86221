import { expect, it } from "vitest";
import { StopPress } from "./stopPress";

it("is unconfirmed after 1.6 s without an answer or another stop", () => {
  const press = new StopPress(null, 1000);
  press.sawStop(null, 1200);
  expect(press.isUnconfirmed(2599)).toBe(false);
  expect(press.isUnconfirmed(2600)).toBe(true);
  press.answered(3, 2700);
  expect(press.isUnconfirmed(2700)).toBe(false);
});

it("becomes the first stop reported by the server or the room state", () => {
  const answered = new StopPress(null, 0);
  answered.answered(3, 100);
  answered.sawStop(4, 200);
  expect(answered.taken).toBe(3);
  const told = new StopPress(null, 0);
  told.sawStop(4, 100);
  expect(told.taken).toBe(4);
});

it("does not count an earlier stop as an answer, since it may be released by now", () => {
  const press = new StopPress(3, 0);
  press.sawStop(3, 2000);
  expect([press.taken, press.isUnconfirmed(2000)]).toEqual([null, true]);
  press.sawStop(4, 2100);
  expect(press.taken).toBe(4);
});

it("is retried after 1.6 s, then every 4 s", () => {
  const press = new StopPress(null, 0);
  expect(press.isDue(1599)).toBe(false);
  expect(press.isDue(1600)).toBe(true);
  press.tried(1600);
  expect(press.isDue(5599)).toBe(false);
  expect(press.isDue(5600)).toBe(true);
  press.answered(3, 5600);
  expect([press.mayTry(9999), press.isDue(9999)]).toEqual([false, false]);
});

it("is not retried after 30 s, and stays unconfirmed", () => {
  const press = new StopPress(null, 1000);
  expect([press.mayTry(30_999), press.isDue(30_999)]).toEqual([true, true]);
  expect([press.mayTry(31_000), press.isDue(31_000)]).toEqual([false, false]);
  expect(press.isUnconfirmed(9e9)).toBe(true);
});

it("counts as unconfirmed since the first of several unanswered presses", () => {
  const first = new StopPress(null, 0);
  const second = new StopPress(null, 1000, first.sinceMs);
  expect(second.number).not.toBe(first.number);
  expect([second.isUnconfirmed(1600), second.isDue(1600)]).toEqual([true, false]);
  expect(second.isDue(2600)).toBe(true);
});

it("gives the card 0.6 s from the answer to show the stop", () => {
  const press = new StopPress(null, 0);
  expect(press.isSettled(9000)).toBe(false);
  press.answered(3, 9000);
  press.sawStop(3, 9500);
  expect([press.isSettled(9599), press.isSettled(9600)]).toEqual([false, true]);
});
