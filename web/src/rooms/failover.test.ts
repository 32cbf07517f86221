import { beforeEach, expect, it } from "vitest";
import { seat } from "../testing/messages";
import { Failover, isSameRoom } from "./failover";

const [one, two] = [seat("one"), seat("two")];
let failover: Failover;
let nowMs: number;

beforeEach(() => {
  failover = new Failover();
  failover.offer([one, two]);
  nowMs = 1000;
});

/** Checks every 50 ms; returns after how long the room counts as frozen, null if never. */
function standsFor(ms: number, moves = false): number | null {
  const startMs = nowMs;
  while (nowMs - startMs < ms) {
    nowMs += 50;
    if (failover.hasStood(nowMs, moves)) return nowMs - startMs;
  }
  return null;
}

it("tries the first room, then the second, then none until there are new tokens", () => {
  expect(failover.next()).toEqual(one);
  failover.plays(one, nowMs);
  failover.failed(one);
  expect(failover.next()).toEqual(two);
  failover.failed(two);
  expect(failover.next()).toBeNull();
  failover.offer([two, one]);
  expect(failover.next()).toEqual(two);
});

it("never switches to the current room, whatever its newest token and place in the list", () => {
  failover.plays(one, nowMs);
  failover.offer([seat("one"), two]);
  expect(failover.next()).toEqual(two);
});

it("gives a room up after half a second without a picture", () => {
  failover.plays(one, nowMs);
  expect(standsFor(5000, true)).toBeNull();
  expect(standsFor(5000)).toBe(500);
});

it("takes ever longer if every room stalls, and is fast again after ten good seconds", () => {
  failover.plays(one, nowMs);
  const waits = [1, 2, 3, 4, 5].map(() => {
    const ms = standsFor(20_000);
    failover.plays(two, nowMs);
    return ms;
  });
  expect(waits).toEqual([500, 1000, 2000, 4000, 8000]);
  expect(standsFor(20_000)).toBe(8000);
  failover.plays(one, nowMs);
  standsFor(11_000, true);
  expect(standsFor(20_000)).toBe(500);
});

it("does not count time in which the page did not run", () => {
  failover.plays(one, nowMs);
  nowMs += 60_000;
  expect(failover.hasStood(nowMs, false)).toBe(false);
});

it("may retry a failed room once another one has played for ten seconds", () => {
  failover.plays(one, nowMs);
  failover.failed(one);
  failover.plays(two, nowMs);
  standsFor(9000, true);
  failover.failed(two);
  expect(failover.next()).toBeNull();
  failover.plays(two, nowMs);
  standsFor(11_000, true);
  expect(failover.next()).toEqual(one);
});

it("tells rooms on one server apart by their tokens, even without a name in them", () => {
  expect(isSameRoom(one, two)).toBe(false);
  expect(isSameRoom(one, { ...one, token: `${one.token}x` })).toBe(true);
  expect(isSameRoom(one, seat("one", { url: "wss://others.example.org" }))).toBe(false);
  expect(isSameRoom({ url: "u", token: "a" }, { url: "u", token: "b" })).toBe(false);
});
