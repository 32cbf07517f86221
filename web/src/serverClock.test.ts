import { describe, expect, it } from "vitest";
import { ServerClock } from "./serverClock";

/** Exchanges once every 200 ms between a page and a server whose clock is ahead and drifts. */
function exchange(
  clock: ServerClock,
  atMs: number,
  { offsetMs = 5000, outMs = 10, backMs = 10, drift = 0 } = {},
): void {
  const serverAt = (pageMs: number) => pageMs * (1 + drift) + offsetMs;
  clock.add({
    sentMs: atMs,
    serverMs: serverAt(atMs + outMs),
    receivedMs: atMs + outMs + backMs,
  });
}

describe("ServerClock", () => {
  it("knows nothing before the first exchange", () => {
    const clock = new ServerClock();
    expect(clock.toServerMs(1)).toBeNull();
    expect(clock.errorMs(1)).toBeNull();
    expect(clock.rttMs).toBeNull();
    expect(clock.slowestMs).toBeNull();
  });

  it("finds the offset of a symmetric link exactly", () => {
    const clock = new ServerClock();
    exchange(clock, 0);
    expect(clock.toServerMs(100)).toBeCloseTo(5100);
    expect(clock.errorMs(20)).toBeCloseTo(10);
  });

  it("is wrong by half the round trip at most, however asymmetric the link is", () => {
    for (const [outMs, backMs] of [
      [0, 80],
      [80, 0],
      [5, 35],
    ] as const) {
      const clock = new ServerClock();
      exchange(clock, 0, { outMs, backMs });
      const wrongMs = Math.abs((clock.toServerMs(100) ?? Number.NaN) - 5100);
      expect(wrongMs).toBeLessThanOrEqual(clock.errorMs(100) ?? Number.NaN);
    }
  });

  it("is not moved by a spike in one direction", () => {
    const clock = new ServerClock();
    for (let at = 0; at < 2000; at += 200) exchange(clock, at);
    for (let at = 2000; at < 6000; at += 200) exchange(clock, at, { backMs: 900 });
    expect(clock.toServerMs(6000)).toBeCloseTo(11_000);
  });

  it("follows a drifting clock and keeps its error bound true", () => {
    const clock = new ServerClock();
    const drift = 100e-6;
    for (let at = 0; at < 600_000; at += 200) {
      exchange(clock, at, { drift, outMs: 10 + (at % 7000) / 500 });
      const wrongMs = Math.abs((clock.toServerMs(at) ?? Number.NaN) - (at * (1 + drift) + 5000));
      expect(wrongMs).toBeLessThanOrEqual(clock.errorMs(at) ?? Number.NaN);
    }
    expect(clock.errorMs(600_000)).toBeLessThan(15);
  });

  it("forgets the past when a clock has jumped", () => {
    const clock = new ServerClock();
    for (let at = 0; at < 2000; at += 200) exchange(clock, at);
    exchange(clock, 2000, { offsetMs: 65_000, backMs: 60 });
    expect(Math.abs((clock.toServerMs(2100) ?? Number.NaN) - 67_100)).toBeLessThanOrEqual(35);
  });

  it("ignores an exchange that ends before it began", () => {
    const clock = new ServerClock();
    clock.add({ sentMs: 10, receivedMs: 5, serverMs: 0 });
    clock.add({ sentMs: Number.NaN, receivedMs: 5, serverMs: 0 });
    expect(clock.toServerMs(1)).toBeNull();
  });

  it("reports the usual round trip, not the worst", () => {
    const clock = new ServerClock();
    for (const backMs of [10, 12, 700, 11, 9]) exchange(clock, 0, { backMs });
    expect(clock.rttMs).toBe(21);
  });

  it("reports the longest of the last few round trips", () => {
    const clock = new ServerClock();
    for (const backMs of [900, 12, 700, 11, 9, 8]) exchange(clock, 0, { backMs });
    expect(clock.slowestMs).toBe(710);
  });

  it("reports by how much the newest round trip exceeds the shortest", () => {
    const clock = new ServerClock();
    expect(clock.queuedMs).toBe(0);
    for (const backMs of [12, 700]) exchange(clock, 0, { backMs });
    expect(clock.queuedMs).toBe(688);
    exchange(clock, 0, { backMs: 12 });
    expect(clock.queuedMs).toBe(0);
  });
});
