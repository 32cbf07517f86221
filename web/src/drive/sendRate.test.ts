import { expect, it } from "vitest";
import { SendRate } from "./sendRate";

const WIDE = { linkBps: 5_000_000, waitingBytes: 0, queuedMs: 0 };

it("sends as often as the server allows if there is room", () => {
  expect(new SendRate(50).next(WIDE, 0)).toBe(50);
  expect(new SendRate(30).next(WIDE, 0)).toBe(30);
});

it.each([
  [null, 20],
  [33_600, 20],
  [304_000, 20],
  [608_000, 40],
  [760_000, 50],
])("over a link of %s bit/s it is %d Hz", (linkBps, hz) => {
  expect(new SendRate(50).next({ linkBps, waitingBytes: 0, queuedMs: 0 }, 0)).toBeCloseTo(hz);
});

it("falls at once when set-points queue, and climbs again by 5 Hz a second", () => {
  const rate = new SendRate(50);
  rate.next(WIDE, 0);
  expect(rate.next({ ...WIDE, waitingBytes: 400 }, 20)).toBe(20);
  expect(rate.next(WIDE, 1020)).toBeCloseTo(25);
  expect(rate.next(WIDE, 2020)).toBeCloseTo(30);
  expect(rate.next(WIDE, 60_000)).toBe(50);
});

it("falls at once when the link proves thin, and below 20 Hz while even those queue", () => {
  const rate = new SendRate(50);
  const thin = { ...WIDE, linkBps: 50_000 };
  rate.next({ ...WIDE, queuedMs: 300 }, 0);
  expect(rate.next(thin, 20)).toBe(20);
  expect(rate.next({ ...thin, queuedMs: 300 }, 40)).toBe(10);
  expect(rate.next(thin, 1040)).toBeCloseTo(15);
  expect(rate.next(thin, 60_000)).toBe(20);
});

it.each([
  [null, 10],
  [303_000, 10],
  [304_000, 20],
])("at rest, over a link of %s bit/s, %d Hz are enough", (linkBps, hz) => {
  const rate = new SendRate(50);
  rate.next({ ...WIDE, linkBps }, 0);
  expect(rate.restHz).toBe(hz);
});

it("ignores a stall of a wide link", () => {
  expect(new SendRate(50).next({ ...WIDE, queuedMs: 300 }, 0)).toBe(50);
});

it("does not count what was just sent as a backlog", () => {
  expect(new SendRate(50).next({ ...WIDE, waitingBytes: 150 }, 0)).toBe(50);
});

it("never exceeds the server's limit, even if that is below the floor", () => {
  expect(new SendRate(10).next({ linkBps: null, waitingBytes: 0, queuedMs: 0 }, 0)).toBe(10);
});
