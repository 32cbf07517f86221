import { expect, it } from "vitest";
import { PictureCounts, SoundCounts } from "./counts";
import { Freezes } from "./freezes";
import type { InboundStats, PlayoutStats, ReceiverStats } from "./stats";

function looked(
  inbound: InboundStats,
  playout: PlayoutStats = {},
  clockHz = 48_000,
): ReceiverStats {
  return { inbound, playout, clockHz };
}

const samples = (ms: number, clockHz = 48_000) => (ms * clockHz) / 1000;

it.each([48_000, 8000])("reports how much sound was concealed and played, at %s Hz", (clockHz) => {
  const counts = new SoundCounts();
  const at = (packetsReceived: number, concealedMs: number, playedMs: number) =>
    looked(
      {
        packetsReceived,
        concealedSamples: samples(concealedMs, clockHz),
        concealmentEvents: concealedMs > 0 ? 1 : 0,
        totalSamplesReceived: samples(playedMs, clockHz),
        insertedSamplesForDeceleration: samples(playedMs / 10, clockHz),
      },
      {},
      clockHz,
    );
  counts.next(at(1, 0, 0), 0);
  const { concealed_ms, played_ms, stretched_ms } = counts.next(at(13, 120, 250), 250);
  expect([concealed_ms, played_ms, stretched_ms]).toEqual([120, 250, 25]);
  expect(counts.pauses.summarize(300)).toEqual({ count: 1, longestMs: 120 });
});

it("counts concealing silence as concealed", () => {
  const counts = new SoundCounts();
  const at = (packetsReceived: number, concealedMs: number) => ({
    packetsReceived,
    concealedSamples: samples(concealedMs),
    silentConcealedSamples: samples(concealedMs / 2),
    concealmentEvents: packetsReceived,
    totalSamplesReceived: 0,
  });
  counts.next(looked(at(1, 0)), 0);
  expect(counts.next(looked(at(2, 2000)), 2000).concealed_ms).toBe(2000);
});

it("reports the built-in player's own counts", () => {
  const counts = new SoundCounts();
  const heard = { rtp: 0, atMs: 0, delayMs: 30, outputMs: 9, playedMs: 500, stretchedMs: 7 };
  expect(counts.builtIn({ ...heard, concealedMs: 40 }, 500)).toEqual({
    delay_ms: 30,
    output_ms: 9,
    concealed_ms: 40,
    played_ms: 500,
    stretched_ms: 7,
  });
  expect(counts.pauses.summarize(600)).toEqual({ count: 1, longestMs: 40 });
});

it("reports the delays of buffer and device", () => {
  const counts = new SoundCounts();
  const at = (count: number) =>
    looked(
      { jitterBufferDelay: 0.04 * count, jitterBufferEmittedCount: count },
      { totalPlayoutDelay: 0.18 * count, totalSamplesCount: count },
    );
  counts.next(at(0), 0);
  const told = counts.next(at(480), 250);
  expect(told.delay_ms).toBeCloseTo(40);
  expect(told.output_ms).toBeCloseTo(180);
});

it("reports nothing that the browser does not count", () => {
  expect(new SoundCounts().next(looked({}), 0)).toEqual({
    delay_ms: null,
    output_ms: null,
    concealed_ms: null,
    played_ms: null,
    stretched_ms: null,
  });
});

it("reports how long the picture was frozen, by the browser's count", () => {
  const counts = new PictureCounts();
  const at = (framesDecoded: number, freezeCount: number, totalFreezesDuration: number) =>
    looked({ framesDecoded, freezeCount, totalFreezesDuration });
  counts.next(at(1, 0, 0), new Freezes(), 0);
  expect(counts.next(at(9, 1, 0.4), new Freezes(), 250).frozen_ms).toBe(400);
  expect(counts.freezes.summarize(300)).toEqual({ count: 1, longestMs: 400 });
});

it("counts presented frames if the browser does not count", () => {
  const counts = new PictureCounts();
  const seen = new Freezes();
  counts.next(looked({ framesDecoded: 1 }), seen, 0);
  for (const atMs of [0, 40, 80, 120, 620]) seen.presented(atMs);
  expect(counts.next(looked({ framesDecoded: 5 }), seen, 650).frozen_ms).toBe(500);
});

it("does not count a picture that was switched off as frozen", () => {
  const counts = new PictureCounts();
  const at = (framesDecoded: number, freezes: number, s: number) =>
    looked({ framesDecoded, freezeCount: freezes, totalFreezesDuration: s });
  counts.next(at(1, 0, 0), new Freezes(), 0);
  counts.rest();
  counts.next(at(1, 0, 0), new Freezes(), 3000);
  counts.next(at(2, 1, 3), new Freezes(), 3250);
  expect(counts.next(at(8, 1, 3), new Freezes(), 3500).frozen_ms).toBe(0);
  expect(counts.freezes.summarize(3500).count).toBe(0);
});
