import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { PlaybackEvents } from "../playback";
import { german } from "../words/de";
import { ENGLISH, language } from "../words/words";
import { SoundPlayback } from "./soundPlayback";

const builtIn = vi.hoisted(() => ({
  lacks: null as string | null,
  routes: true,
  loudness: 1,
  setOutput: vi.fn(async (_: string) => {}),
  starts: true,
  isReady: false,
  events: { plays() {}, failed(_: string) {}, silenced() {}, resumed() {} },
  levels: [0.5, 0.25] as number[] | null,
  play: vi.fn(),
  rest: vi.fn(),
  share: vi.fn(),
}));

vi.mock("./builtInPlayer", () => ({
  lacking: () => builtIn.lacks,
  routes: () => builtIn.routes,
  BuiltInPlayer: class {
    constructor(events: typeof builtIn.events) {
      builtIn.events = events;
    }
    get isReady() {
      return builtIn.isReady;
    }
    async start() {
      builtIn.isReady = builtIn.starts;
      return builtIn.starts;
    }
    play = builtIn.play;
    rest = builtIn.rest;
    share = builtIn.share;
    setOutput = builtIn.setOutput;
    set loudness(loudness: number) {
      builtIn.loudness = loudness;
    }
    watch() {}
    negotiated() {}
    heard() {
      return { rtp: 1 };
    }
    get levels() {
      return builtIn.levels;
    }
  },
}));

let emitted = 0;
let audioLevel: number | undefined;
const receiver = {
  track: {},
  async getStats() {
    return new Map([["a", { type: "inbound-rtp", jitterBufferEmittedCount: emitted, audioLevel }]]);
  },
};
const element = {
  addEventListener: vi.fn(),
  muted: false,
  volume: 1,
  setSinkId: vi.fn(async (_: string) => {}),
  play: vi.fn(async () => {}),
  pause: vi.fn(),
  srcObject: null,
};
const changed = vi.fn();
const reconnect = vi.fn();

async function made({
  isStarted = true,
  ...told
}: { isStarted?: boolean } & PlaybackEvents = {}): Promise<SoundPlayback> {
  const playback = new SoundPlayback({ changed, reconnect, ...told });
  if (isStarted) await playback.start("built-in");
  playback.attach(element as unknown as HTMLAudioElement);
  playback.setReceiver(receiver as unknown as RTCRtpReceiver);
  return playback;
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("MediaStream", class {});
  vi.clearAllMocks();
  Object.assign(builtIn, {
    lacks: null,
    starts: true,
    isReady: false,
    routes: true,
    loudness: 1,
  });
  element.muted = false;
  emitted = 0;
});

afterEach(() => {
  language.value = ENGLISH;
});

it("plays by the browser until the built-in player starts", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  expect(element.play).toHaveBeenCalled();
  expect(builtIn.play).toHaveBeenCalled();
  expect(playback.heard(0)).toBeNull();
  builtIn.events.plays();
  expect(element.pause).toHaveBeenCalledOnce();
  expect(changed).toHaveBeenLastCalledWith({ by: "built-in", why: null });
  expect(playback.heard(0)).not.toBeNull();
});

it("reports two levels for the built-in player, and one for the browser's", async () => {
  const playback = await made();
  playback.choose("auto", null);
  audioLevel = 0.1;
  expect(await playback.levels()).toEqual([]);
  playback.play();
  const [level, ...others] = await playback.levels();
  expect(level).toBeCloseTo(2 / 3);
  expect(others).toEqual([]);
  audioLevel = undefined;
  expect(await playback.levels()).toEqual([]);
  builtIn.events.plays();
  expect(await playback.levels()).toEqual([0.5, 0.25]);
});

it("does not let the built-in player start once the browser's is chosen", async () => {
  const playback = await made();
  playback.choose("built-in", null);
  playback.play();
  expect(builtIn.rest).not.toHaveBeenCalled();
  playback.choose("browser", null);
  expect(builtIn.rest).toHaveBeenCalled();
});

it("never starts the built-in player if the browser's is chosen", async () => {
  const playback = await made();
  playback.choose("browser", null);
  playback.play();
  expect(builtIn.play).not.toHaveBeenCalled();
  expect(changed).toHaveBeenLastCalledWith({ by: "browser", why: null });
});

it("says why the built-in player cannot play", async () => {
  builtIn.lacks = "over HTTPS it could";
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  expect(builtIn.play).not.toHaveBeenCalled();
  expect(changed).toHaveBeenLastCalledWith({ by: "browser", why: "over HTTPS it could" });
});

it("reports when a call pauses the built-in player, and resumes with it", async () => {
  const [silenced, resumed] = [vi.fn(), vi.fn()];
  const playback = await made({ silenced, resumed });
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  builtIn.events.silenced();
  expect(silenced).toHaveBeenCalledOnce();
  builtIn.events.resumed();
  expect(resumed).toHaveBeenCalledOnce();
  builtIn.play.mockClear();
  playback.play();
  expect(builtIn.play).toHaveBeenCalledOnce();
});

it("reconnects if the built-in player is chosen later", async () => {
  const playback = await made({ isStarted: false });
  playback.choose("built-in", null);
  await vi.advanceTimersByTimeAsync(0);
  expect(reconnect).toHaveBeenCalledOnce();
});

it("stays with the browser's if the built-in player fails to load", async () => {
  builtIn.starts = false;
  const playback = await made({ isStarted: false });
  playback.choose("built-in", null);
  await vi.advanceTimersByTimeAsync(0);
  expect(reconnect).not.toHaveBeenCalled();
  expect(changed).toHaveBeenLastCalledWith({
    by: "browser",
    why: "WAX's own player could not be loaded",
  });
});

it("returns to the browser's player only once that has sound", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  playback.choose("browser", null);
  await vi.advanceTimersByTimeAsync(100);
  expect(builtIn.share).toHaveBeenCalledOnce();
  expect(builtIn.rest).not.toHaveBeenCalled();
  expect(element.muted).toBe(true);
  emitted = 5000;
  await vi.advanceTimersByTimeAsync(40);
  expect(builtIn.rest).toHaveBeenCalledOnce();
  expect(element.muted).toBe(false);
  expect(changed).toHaveBeenLastCalledWith({ by: "browser", why: null });
});

it("does not wait forever for the browser's player", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  playback.choose("browser", null);
  await vi.advanceTimersByTimeAsync(1100);
  expect(builtIn.rest).toHaveBeenCalledOnce();
});

it("unmutes at once if the built-in player fails while the browser's player fills its buffer", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  playback.choose("browser", null);
  await vi.advanceTimersByTimeAsync(40);
  expect(element.muted).toBe(true);
  builtIn.events.failed("the sound's device has stopped");
  expect(element.muted).toBe(false);
  await vi.advanceTimersByTimeAsync(2000);
  expect(element.muted).toBe(false);
  expect(changed).toHaveBeenLastCalledWith({ by: "browser", why: null });
});

it("falls back at once when the built-in player fails, and retries it later", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  element.play.mockClear();
  builtIn.play.mockClear();
  builtIn.events.failed("the sound's device has stopped");
  expect(element.play).toHaveBeenCalledOnce();
  expect(changed).toHaveBeenLastCalledWith({
    by: "browser",
    why: "the sound's device has stopped",
  });
  expect(builtIn.play).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(5000);
  expect(builtIn.play).toHaveBeenCalledOnce();
  builtIn.events.plays();
  builtIn.events.failed("the sound's device has stopped");
  await vi.advanceTimersByTimeAsync(9000);
  expect(builtIn.play).toHaveBeenCalledOnce();
  await vi.advanceTimersByTimeAsync(1000);
  expect(builtIn.play).toHaveBeenCalledTimes(2);
});

it("silences both while the sound is off", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  playback.pause();
  expect(element.pause).toHaveBeenCalled();
  expect(builtIn.rest).toHaveBeenCalledOnce();
  builtIn.play.mockClear();
  playback.choose("built-in", null);
  expect(builtIn.play).not.toHaveBeenCalled();
});

it("sets the volume of both, and mutes both without stopping them", async () => {
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  playback.volume = 0.5;
  expect([builtIn.loudness, element.volume, element.muted]).toEqual([0.25, 0.25, false]);
  playback.isMuted = true;
  expect([builtIn.loudness, element.muted]).toEqual([0, true]);
  playback.isDucked = true;
  playback.isMuted = false;
  expect([builtIn.loudness, element.muted]).toEqual([0, true]);
  playback.isDucked = false;
  expect([builtIn.loudness, element.volume, element.muted]).toEqual([0.25, 0.25, false]);
  expect(builtIn.rest).not.toHaveBeenCalled();
});

it("sets the device of both, and falls back to the default if it is gone", async () => {
  const playback = await made();
  expect(await playback.setOutput("headphones")).toBe(true);
  expect(element.setSinkId).toHaveBeenLastCalledWith("headphones");
  expect(builtIn.setOutput).toHaveBeenLastCalledWith("headphones");
  element.setSinkId.mockRejectedValueOnce(new DOMException("gone", "NotFoundError"));
  expect(await playback.setOutput("unplugged")).toBe(false);
  expect(element.setSinkId).toHaveBeenLastCalledWith("");
  expect(builtIn.setOutput).toHaveBeenLastCalledWith("");
});

it("uses the browser's player if the built-in one cannot reach the chosen device", async () => {
  builtIn.routes = false;
  const playback = await made();
  playback.choose("auto", null);
  playback.play();
  builtIn.events.plays();
  await playback.setOutput("headphones");
  await vi.advanceTimersByTimeAsync(1100);
  expect(changed).toHaveBeenLastCalledWith({
    by: "browser",
    why: expect.stringContaining("default device only"),
  });
  language.value = german;
  await playback.setOutput("speakers");
  expect(changed).toHaveBeenLastCalledWith({
    by: "browser",
    why: expect.stringContaining("nur auf dem Standardgerät"),
  });
  builtIn.play.mockClear();
  await playback.setOutput("");
  expect(builtIn.play).toHaveBeenCalledOnce();
});
