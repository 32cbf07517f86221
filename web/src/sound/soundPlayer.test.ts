import { describe, expect, it } from "vitest";
import { type Arrival, simulate } from "../testing/simulate";
import { SoundPlayer } from "./soundPlayer";

/** Repeatable random numbers from 0 to 1. */
function randomOf(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1_103_515_245) + 12_345) & 0x7fffffff;
    return state / 0x7fffffff;
  };
}

/** Packets of 20 ms, each delayed by `delayMs`; a link keeps their order. */
function trace(seconds: number, delayMs: (sentMs: number) => number | null): Arrival[] {
  const found: Arrival[] = [];
  let lastMs = 0;
  for (let sentMs = 20; sentMs <= seconds * 1000; sentMs += 20) {
    const onTheWayMs = delayMs(sentMs);
    if (onTheWayMs === null) continue;
    lastMs = Math.max(lastMs, sentMs + onTheWayMs);
    found.push({ sentMs, arrivedMs: lastMs });
  }
  return found;
}

const quantile = (values: number[], share: number) =>
  values.toSorted((a, b) => a - b)[Math.floor((values.length - 1) * share)] ?? Number.NaN;

describe("on a link without jitter", () => {
  it("plays with hardly more delay than one packet", () => {
    const { agesMs, concealedShare, stretchedShare, droppedShare } = simulate(trace(30, () => 20));
    expect(quantile(agesMs, 0.5)).toBeLessThan(20 + 20 + 10);
    expect([concealedShare, stretchedShare, droppedShare]).toEqual([0, 0, 0]);
  });

  it.each([-150, 150])("follows a device that is %i ppm off", (driftPpm) => {
    const { agesMs, concealedShare, stretchedShare } = simulate(
      trace(120, () => 20),
      { driftPpm },
    );
    expect(concealedShare + stretchedShare).toBe(0);
    expect(quantile(agesMs, 0.99) - quantile(agesMs, 0.01)).toBeLessThan(8);
  });
});

it("waits for packets that are repeatedly late", () => {
  const random = randomOf(1);
  const { agesMs, concealedShare } = simulate(trace(60, () => 20 + 60 * random()));
  expect(concealedShare).toBeLessThan(0.001);
  expect(quantile(agesMs, 0.5)).toBeLessThan(20 + 20 + 60 + 10);
});

it("conceals lost packets, and keeps its delay", () => {
  const random = randomOf(2);
  const { agesMs, concealedShare } = simulate(trace(60, () => (random() < 0.05 ? null : 20)));
  expect(concealedShare).toBeGreaterThan(0.03);
  expect(concealedShare).toBeLessThan(0.07);
  expect(quantile(agesMs, 0.5)).toBeLessThan(50);
});

it("returns to its old delay within ten seconds of the last stall", () => {
  const stall = (sentMs: number) => (sentMs < 20_000 ? Math.max(20, 220 - (sentMs % 2000)) : 20);
  const { agesMs } = simulate(trace(40, stall), { settleMs: 35_000 });
  expect(quantile(agesMs, 0.5)).toBeLessThan(55);
});

it("plays live again half a second after an outage", () => {
  const outage = (sentMs: number) => (sentMs >= 10_000 && sentMs < 12_000 ? 12_000 - sentMs : 20);
  const { agesMs } = simulate(trace(13, outage), { settleMs: 12_500 });
  expect(quantile(agesMs, 0.5)).toBeLessThan(300);
});

it("continues at once on a link that has become much slower", () => {
  const slower = (sentMs: number) => (sentMs < 10_000 ? 20 : 2500);
  const { agesMs, concealedShare } = simulate(trace(16, slower), { settleMs: 12_700 });
  expect(quantile(agesMs, 0.1)).toBeGreaterThan(2500);
  expect(quantile(agesMs, 0.9)).toBeLessThan(2600);
  expect(concealedShare).toBeLessThan(0.01);
});

describe("on any link", () => {
  const anything = (seed: number) => {
    const random = randomOf(seed);
    const [jitterMs, stallMs, lost] = [200 * random(), 1500 * random(), 0.3 * random()];
    const everyMs = 500 + 4000 * random();
    return trace(36, (sentMs) => {
      if (random() < lost) return null;
      if (sentMs > 18_000) return 20;
      return 20 + jitterMs * random() + Math.max(0, stallMs - (sentMs % everyMs));
    });
  };

  const seeds = Array.from({ length: 10 }, (_, i) => i + 1);

  it.each(seeds)("ends up with a small delay, in case %i", (seed) => {
    const { agesMs } = simulate(anything(seed), { settleMs: 34_000 });
    expect(agesMs.length).toBeGreaterThan(0);
    expect(quantile(agesMs, 0.9)).toBeLessThan(80);
  });

  it.each(seeds)("only moves forward, in case %i", (seed) => {
    const random = randomOf(seed);
    const player = new SoundPlayer();
    const out = new Float32Array(128);
    let lastRtp = 0;
    let isLoud = false;
    let wentBack = false;
    // Checked once per case, since each has 1500 blocks.
    for (let frame = 0; frame < 48_000 * 4; frame += 128) {
      const number = Math.floor(frame / 960 + 6 * (random() - 0.5));
      if (number >= 0 && random() < 0.2) {
        player.arrive(number * 960, [new Float32Array(960).fill(0.5)], frame);
      }
      player.render([out], frame);
      isLoud ||= !out.every((one) => Math.abs(one) <= 1);
      const { rtp } = player;
      if (rtp === null) continue;
      wentBack ||= rtp < lastRtp;
      lastRtp = rtp;
    }
    expect({ isLoud, wentBack }).toEqual({ isLoud: false, wentBack: false });
    expect(lastRtp).toBeGreaterThan(0);
  });
});

it("is silent before anything has arrived, and after everything has been played", () => {
  const player = new SoundPlayer();
  const out = new Float32Array(128).fill(1);
  player.render([out], 0);
  expect(out.every((one) => one === 0)).toBe(true);
  expect(player.rtp).toBeNull();
  player.arrive(0, [new Float32Array(960).fill(0.5)], 0);
  for (let frame = 128; frame < 48_000; frame += 128) player.render([out], frame);
  expect(out.every((one) => one === 0)).toBe(true);
});

/** Plays seconds of packets with one value, starting at an RTP time. */
function play(player: SoundPlayer, fromS: number, toS: number, rtp: number, value = 0): number {
  const out = new Float32Array(128);
  const begin = fromS * 48_000;
  let sent = 0;
  for (let frame = begin; frame < toS * 48_000; frame += 128) {
    for (; begin + sent <= frame; sent += 960) {
      player.arrive(rtp + sent, [new Float32Array(960).fill(value)], frame);
    }
    player.render([out], frame);
  }
  return out[0] ?? Number.NaN;
}

it("restarts when the sender does", () => {
  const player = new SoundPlayer();
  expect(play(player, 0, 1, 0, 0.1)).toBeCloseTo(0.1);
  expect(play(player, 1, 2, 2 ** 31, 0.7)).toBeCloseTo(0.7);
  expect(player.rtp).toBeGreaterThan(2 ** 31);
});

it("keeps the minimum delay that is set", () => {
  const player = new SoundPlayer();
  player.leastDelayMs = 200;
  play(player, 0, 1, 0);
  expect(player.aheadMs).toBeGreaterThan(190);
  expect(player.aheadMs).toBeLessThan(230);
});

it("keeps the ears apart, in played and in concealed sound", () => {
  const player = new SoundPlayer();
  const left = new Float32Array(128);
  const right = new Float32Array(128);
  let isApart = true;
  for (let frame = 0, sent = 0; frame < 48_000; frame += 128) {
    for (; sent <= frame; sent += 960) {
      if ((sent / 960) % 10 === 9) continue; // lost
      const packet = [0.5, -0.2].map((value) => new Float32Array(960).fill(value));
      player.arrive(sent, packet, frame);
    }
    player.render([left, right], frame);
    if (frame < 9600) continue;
    isApart &&= left.every((one, i) => Math.abs((right[i] ?? 0) + 0.4 * one) < 1e-6);
  }
  expect(isApart).toBe(true);
  expect(player.counts.concealed).toBeGreaterThan(0);
});
