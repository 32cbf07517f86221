// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Link } from "../link/link";
import type { Report } from "../messages";
import { ServerClock } from "../serverClock";
import type { Heard } from "../sound/builtInPlayer";
import type { Facts } from "../state";
import { Reporter } from "./report";

/** The browser's stats of the two receivers; the test changes them over time. */
let sound: { inbound: object; playout: object | null; heardAtMs: number; rtp: number };
let picture: object;
let wants: { sound: boolean; picture: boolean };
let sent: Report[];
let facts: Facts[];
let looks: number;
let reporter: Reporter;
let own: Heard | null;
let link: { isThin: boolean; mayDrive: boolean };

function receiver(stats: () => [string, object | null][]) {
  return {
    getStats: async () => {
      looks++;
      return new Map(stats().filter(([, one]) => one));
    },
    getSynchronizationSources: () => [
      { source: 1, timestamp: performance.timeOrigin + sound.heardAtMs, rtpTimestamp: sound.rtp },
    ],
  };
}

beforeEach(() => {
  vi.useFakeTimers();
  sound = { inbound: {}, playout: null, heardAtMs: 0, rtp: 0 };
  picture = {};
  wants = { sound: true, picture: true };
  sent = [];
  own = null;
  facts = [];
  looks = 0;
  const clock = new ServerClock();
  clock.add({ sentMs: 0, receivedMs: 2, serverMs: 1 });
  const made = {
    clock,
    isThin: false,
    mayDrive: false,
    peer: {
      sound: receiver(() => [
        ["in", { type: "inbound-rtp", codecId: "c", ...sound.inbound }],
        ["c", { type: "codec", clockRate: 48_000 }],
        ["out", sound.playout && { type: "media-playout", ...sound.playout }],
      ]),
      picture: receiver(() => [["in", { type: "inbound-rtp", ...picture }]]),
    },
    sendDrive: (report: Report) => sent.push(report),
  };
  link = made;
  reporter = new Reporter({
    link: made as unknown as Link,
    wants: () => wants,
    heard: () => own,
    onFacts: (now) => facts.push(now),
  });
  for (const [kind, rate_hz] of [
    ["audio", 48_000],
    ["video", 90_000],
  ] as const) {
    reporter.mapped({ type: "rtp_clock", kind, rate_hz, rtp_origin: 0, origin_server_ms: 0 });
  }
});

afterEach(() => {
  vi.clearAllTimers();
});

/** Sound captured this long ago is handed to the device now. */
function hear(ageMs: number): void {
  sound.heardAtMs = performance.now();
  sound.rtp = (sound.heardAtMs - ageMs) * 48;
}

it("reports the ages all the same if getStats never settles", async () => {
  const { peer } = link as unknown as { peer: { sound: object; picture: object } };
  const getStats = vi.fn(() => new Promise(() => {}));
  for (const one of [peer.sound, peer.picture]) Object.assign(one, { getStats });
  await vi.advanceTimersByTimeAsync(4200);
  hear(50);
  await vi.advanceTimersByTimeAsync(250);
  expect(sent.at(-1)?.sound?.age_ms).toBeCloseTo(50);
  expect(sent.at(-1)?.picture).toMatchObject({ delay_ms: null });
  const asked = getStats.mock.calls.length;
  await vi.advanceTimersByTimeAsync(2000);
  expect(getStats).toHaveBeenCalledTimes(asked);
});

it("adds the device's delay to the sound's age, if the browser reports it", async () => {
  hear(50);
  await vi.advanceTimersByTimeAsync(250);
  expect(sent.at(-1)?.sound).toMatchObject({ output_ms: null });
  expect(sent.at(-1)?.sound?.age_ms).toBeCloseTo(50);
  sound.playout = { totalPlayoutDelay: 0, totalSamplesCount: 0 };
  hear(50);
  await vi.advanceTimersByTimeAsync(250);
  sound.playout = { totalPlayoutDelay: 0.18 * 12_000, totalSamplesCount: 12_000 };
  hear(50);
  await vi.advanceTimersByTimeAsync(250);
  expect(sent.at(-1)?.sound?.output_ms).toBeCloseTo(180);
  expect(sent.at(-1)?.sound?.age_ms).toBeCloseTo(230);
});

it("reads each receiver once a report, except one that is off", async () => {
  await vi.advanceTimersByTimeAsync(1000);
  expect([sent.length, looks]).toEqual([4, 8]);
  wants = { sound: false, picture: true };
  await vi.advanceTimersByTimeAsync(1000);
  expect([sent.length, looks]).toEqual([8, 12]);
  expect(sent.at(-1)?.sound).toBeNull();
});

it("reports often until it has settled, but over a slow link once a second from the start", async () => {
  await vi.advanceTimersByTimeAsync(10_000);
  expect(sent).toHaveLength(40);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(sent).toHaveLength(50);
  link.mayDrive = true;
  await vi.advanceTimersByTimeAsync(10_000);
  expect(sent).toHaveLength(90);
  link.isThin = true;
  reporter.reset();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(sent).toHaveLength(100);
});

it("reports within 100 ms that the built-in player's delay has moved, except over a slow link", async () => {
  const times = {
    atMs: 1000,
    delayMs: 40,
    outputMs: 30,
    concealedMs: 0,
    playedMs: 0,
    stretchedMs: 0,
  };
  const hears = (ageMs: number) => {
    own = { ...times, rtp: (times.atMs - ageMs) * 48 };
  };
  hears(90);
  await vi.advanceTimersByTimeAsync(20_000);
  for (const [isThin, ageMs, reports] of [
    [false, 100, 0],
    [false, 200, 1],
    [false, 205, 0],
    [true, 300, 0],
  ] as const) {
    link.isThin = isThin;
    hears(ageMs);
    const before = sent.length;
    await vi.advanceTimersByTimeAsync(200);
    expect(sent.length - before).toBe(reports);
    await vi.advanceTimersByTimeAsync(800);
  }
});

it("shows the age with its whole possible error", async () => {
  reporter.refreshMs = 16;
  await vi.advanceTimersByTimeAsync(240);
  reporter.picture.presented(200 * 90, 240);
  await vi.advanceTimersByTimeAsync(10);
  expect(facts[0]?.pictureMs).toBeCloseTo(40);
  expect(facts[0]?.pictureErrorMs).toBeCloseTo(1 + 8, 0);
});

it("shows pauses and freezes, also from samples that are not reported", async () => {
  link.isThin = true;
  const at = (concealedMs: number, freezes: number) => {
    const packetsReceived = performance.now() + 1;
    sound.inbound = {
      packetsReceived,
      concealedSamples: concealedMs * 48,
      concealmentEvents: concealedMs > 0 ? 1 : 0,
      totalSamplesReceived: packetsReceived * 48,
    };
    picture = {
      framesDecoded: packetsReceived,
      freezeCount: freezes,
      totalFreezesDuration: freezes * 0.3,
    };
  };
  for (const [concealedMs, freezes] of [
    [0, 0],
    [100, 1],
    [300, 1],
    [300, 1],
  ] as const) {
    at(concealedMs, freezes);
    await vi.advanceTimersByTimeAsync(250);
  }
  at(300, 1);
  await vi.advanceTimersByTimeAsync(250);
  expect(sent).toHaveLength(2);
  expect(facts.at(-1)).toMatchObject({
    pauses: { count: 1, longestMs: 300 },
    freezes: { count: 1, longestMs: 300 },
  });
  expect(sent.at(-1)?.sound?.concealed_ms).toBe(300);
  expect(sent.at(-1)?.picture?.frozen_ms).toBe(300);
});

it("does not call a hidden picture old", async () => {
  reporter.picture.presented(0, 40);
  vi.spyOn(document, "hidden", "get").mockReturnValue(true);
  await vi.advanceTimersByTimeAsync(5000);
  expect(sent.at(-1)?.picture).toMatchObject({ age_ms: null, rate_hz: null });
});

it("shows the sound's jitter and buffering, and how many pictures arrive", async () => {
  sound.inbound = { packetsReceived: 1, jitter: 0.0125 };
  picture = { framesReceived: 100 };
  await vi.advanceTimersByTimeAsync(1000);
  picture = { framesReceived: 115 };
  await vi.advanceTimersByTimeAsync(1000);
  expect(facts.at(-1)?.jitterMs).toBe(12.5);
  expect(facts.at(-1)?.arrivedFps).toBe(15);
});
