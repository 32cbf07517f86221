import { beforeEach, expect, it, vi } from "vitest";
import { BuiltInPlayer, lacking, loadAhead, routes } from "./builtInPlayer";

class FakePort {
  onmessage: ((event: { data: unknown }) => void) | null = null;
  said: unknown[] = [];
  postMessage(message: unknown): void {
    this.said.push(message);
  }
  says(data: unknown): void {
    this.onmessage?.({ data });
  }
}

class FakeWorker extends FakePort {
  static last: FakeWorker;
  onerror: (() => void) | null = null;
  constructor() {
    super();
    FakeWorker.last = this;
  }
}

class FakeNode {
  static last: FakeNode;
  port = new FakePort();
  onprocessorerror: (() => void) | null = null;
  connect = vi.fn((next: unknown) => next);
  disconnect = vi.fn();
  constructor() {
    FakeNode.last = this;
  }
}

class FakeContext extends EventTarget {
  static made = 0;
  static last: FakeContext;
  state = "running";
  currentTime = 10;
  destination = {};
  audioWorklet = { addModule: async () => {} };
  resume = vi.fn(async () => {});
  suspend = async () => {};
  close = async () => {};
  setSinkId = vi.fn(async (_id: string) => {});
  gain = { gain: { value: 1 }, connect: vi.fn() };
  createGain = () => this.gain;
  getOutputTimestamp = () => ({ contextTime: 9.97, performanceTime: 5000 });
  constructor() {
    super();
    FakeContext.made++;
    FakeContext.last = this;
  }
  becomes(state: string): void {
    this.state = state;
    this.dispatchEvent(new Event("statechange"));
  }
}

const events = { plays: vi.fn(), failed: vi.fn(), silenced: vi.fn(), resumed: vi.fn() };
const TOLD = {
  frame: 480_000,
  rtp: 7,
  aheadMs: 20,
  played: 960,
  concealed: 96,
  stretched: 48,
  dropped: 0,
  levels: [0.5, 0.25],
};
const feeds = () =>
  FakeWorker.last.said.flatMap((one) => (one as { playing?: string }).playing ?? []);

async function playing(Player = BuiltInPlayer): Promise<BuiltInPlayer> {
  const player = new Player(events);
  const ready = player.start();
  FakeWorker.last.says("ready");
  expect(await ready).toBe(true);
  await player.play();
  return player;
}

function stub(): void {
  vi.stubGlobal("Worker", FakeWorker);
  vi.stubGlobal("AudioContext", FakeContext);
  vi.stubGlobal("AudioWorkletNode", FakeNode);
}

beforeEach(() => {
  vi.useFakeTimers();
  stub();
  vi.clearAllMocks();
  FakeContext.made = 0;
});

it("shares the packets until it plays, then gets them alone", async () => {
  const player = await playing();
  expect(feeds()).toEqual(["both"]);
  expect(player.heard(5000)).toBeNull();
  FakeNode.last.port.says({ ...TOLD, rtp: null });
  expect(events.plays).not.toHaveBeenCalled();
  FakeNode.last.port.says(TOLD);
  expect(events.plays).toHaveBeenCalledOnce();
  expect(feeds()).toEqual(["both", "built-in"]);
});

it("reports the level of each ear while it plays", async () => {
  const player = await playing();
  expect(player.levels).toBeNull();
  FakeNode.last.port.says(TOLD);
  expect(player.levels).toEqual([0.5, 0.25]);
  player.rest();
  expect(player.levels).toBeNull();
});

it("reports what is heard when, by the device's own time", async () => {
  const player = await playing();
  FakeNode.last.port.says(TOLD);
  const heard = player.heard(5000);
  expect(heard?.rtp).toBe(7);
  expect(heard?.atMs).toBeCloseTo(5030);
  expect(heard?.outputMs).toBeCloseTo(30);
  expect([heard?.playedMs, heard?.concealedMs, heard?.stretchedMs]).toEqual([20, 2, 1]);
});

it("never asks Firefox for its device's latency, which can deadlock the page", async () => {
  vi.stubGlobal("navigator", { userAgent: "Gecko/20100101 Firefox/153.0" });
  vi.resetModules();
  const { BuiltInPlayer: InFirefox } = await import("./builtInPlayer");
  vi.unstubAllGlobals();
  stub();
  const player = await playing(InFirefox);
  const asked = vi.fn(() => 0);
  Object.defineProperty(FakeContext.last, "outputLatency", { get: asked });
  Object.defineProperty(FakeContext.last, "getOutputTimestamp", { value: asked });
  FakeNode.last.port.says(TOLD);
  expect(player.heard(5000)).toMatchObject({ rtp: 7, atMs: expect.closeTo(5030) });
  expect(asked).not.toHaveBeenCalled();
});

it.each([
  ["the decoder", () => FakeWorker.last.says({ failed: "EncodingError" }), /EncodingError/],
  ["the silent decoder", () => FakeWorker.last.says("silent"), /decoder returns nothing/],
  ["the worklet", () => FakeNode.last.onprocessorerror?.(), /player has failed/],
  ["the device", () => vi.advanceTimersByTime(300), /device has stopped/],
])("gives the sound back within 300 ms when %s fails", async (_, fail, why) => {
  const player = await playing();
  FakeNode.last.port.says(TOLD);
  fail();
  expect(events.failed).toHaveBeenCalledExactlyOnceWith(expect.stringMatching(why));
  expect(feeds().at(-1)).toBe("browser");
  expect(player.heard(5000)).toBeNull();
  await player.play();
  expect(FakeContext.made).toBe(2);
});

/** A browser in which this step of opening the device never settles. */
function hangs(step: "resume" | "addModule" | "setSinkId"): void {
  const never = vi.fn(() => new Promise<never>(() => {}));
  class Hung extends FakeContext {
    override state = "suspended";
    constructor() {
      super();
      Object.assign(step === "addModule" ? this.audioWorklet : this, { [step]: never });
    }
  }
  vi.stubGlobal("AudioContext", Hung);
}

it.each(["resume", "addModule", "setSinkId"] as const)(
  "leaves the sound to the browser's player after 4 s, and says why, if %s hangs",
  async (step) => {
    vi.stubGlobal("navigator", { userActivation: { hasBeenActive: true } });
    hangs(step);
    const player = new BuiltInPlayer(events);
    await player.setOutput("headphones");
    void player.start();
    FakeWorker.last.says("ready");
    void player.play();
    await vi.advanceTimersByTimeAsync(3999);
    expect(events.failed).not.toHaveBeenCalled();
    await vi.advanceTimersByTimeAsync(1);
    const why = expect.stringMatching(`does not answer .*${step}`);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith(why);
    expect(feeds().at(-1)).toBe("browser");
  },
);

it("waits for a touch as long as it takes", async () => {
  vi.stubGlobal("navigator", { userActivation: { hasBeenActive: false } });
  hangs("resume");
  await playing();
  await vi.advanceTimersByTimeAsync(60_000);
  expect(events.failed).not.toHaveBeenCalled();
});

it("waits for a phone call to end, and resumes with the same device", async () => {
  const player = await playing();
  FakeNode.last.port.says(TOLD);
  FakeContext.last.becomes("interrupted");
  expect(events.silenced).toHaveBeenCalledOnce();
  expect(player.heard(5000)).toBeNull();
  vi.advanceTimersByTime(60_000);
  FakeContext.last.becomes("suspended");
  expect(events.resumed).toHaveBeenCalledOnce();
  FakeContext.last.resume.mockClear();
  await player.play();
  expect(FakeContext.last.resume).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(900);
  FakeNode.last.port.says(TOLD);
  expect(player.heard(5000)?.rtp).toBe(7);
  expect(events.failed).not.toHaveBeenCalled();
  expect(FakeContext.made).toBe(1);
});

it.each([
  [
    "after a call",
    (player: BuiltInPlayer) => [FakeContext.last.becomes("suspended"), player.play()],
  ],
  ["during one, for who asks", (player: BuiltInPlayer) => [player.play()]],
])("gives the sound back if the device stays silent %s", async (_, goOn) => {
  const player = await playing();
  FakeNode.last.port.says(TOLD);
  FakeContext.last.becomes("interrupted");
  await Promise.all(goOn(player));
  vi.advanceTimersByTime(1100);
  expect(events.failed).toHaveBeenCalledOnce();
});

it("reports no failure of a resting device", async () => {
  const player = await playing();
  FakeNode.last.port.says(TOLD);
  player.rest();
  FakeContext.last.becomes("interrupted");
  FakeContext.last.becomes("suspended");
  expect(events.silenced).not.toHaveBeenCalled();
  expect(events.resumed).not.toHaveBeenCalled();
});

it("does not mistake a busy page for a lost device", async () => {
  await playing();
  FakeNode.last.port.says(TOLD);
  for (let i = 0; i < 20; i++) {
    vi.advanceTimersByTime(100);
    FakeNode.last.port.says(TOLD);
  }
  expect(events.failed).not.toHaveBeenCalled();
});

it("reports nothing more once it rests", async () => {
  const player = await playing();
  player.rest();
  FakeNode.last.port.says(TOLD);
  vi.advanceTimersByTime(5000);
  expect(events.plays).not.toHaveBeenCalled();
  expect(feeds()).toEqual(["both", "browser"]);
});

it("is not ready if its worker fails to load", async () => {
  const player = new BuiltInPlayer(events);
  const ready = player.start();
  FakeWorker.last.onerror?.();
  expect(await ready).toBe(false);
  expect(player.isReady).toBe(false);
});

it("says what a browser lacks", () => {
  const able = {
    isSecureContext: true,
    RTCRtpScriptTransform: 1,
    AudioDecoder: 1,
    AudioWorkletNode: 1,
  };
  const of = (scope: object) => lacking(scope as unknown as typeof globalThis);
  expect(of(able)).toBeNull();
  expect(of({ ...able, isSecureContext: false })).toMatch(/HTTPS/);
  const { AudioDecoder: _, ...older } = able;
  expect(of(older)).toMatch(/lacks/);
});

it("has the wanted volume, also on a device that it opens later", async () => {
  const player = await playing();
  expect(FakeContext.last.gain.connect).not.toHaveBeenCalled();
  player.loudness = 0.25;
  expect(FakeContext.last.gain.gain.value).toBe(0.25);
  expect(FakeContext.last.gain.connect).toHaveBeenCalledWith(FakeContext.last.destination);
  FakeNode.last.onprocessorerror?.();
  await player.play();
  expect(FakeContext.made).toBe(2);
  expect(FakeContext.last.gain.gain.value).toBe(0.25);
  player.loudness = 1;
  expect(FakeContext.last.gain.gain.value).toBe(1);
});

it("plays on the chosen device, also if it is opened later", async () => {
  const player = await playing();
  await player.setOutput("headphones");
  expect(FakeContext.last.setSinkId).toHaveBeenCalledWith("headphones");
  FakeNode.last.onprocessorerror?.();
  await player.play();
  expect(FakeContext.made).toBe(2);
  expect(FakeContext.last.setSinkId).toHaveBeenCalledWith("headphones");
});

it("knows whether it can choose the device", () => {
  const of = (scope: object) => routes(scope as unknown as typeof globalThis);
  expect(of({ AudioContext: { prototype: { setSinkId: 1 } } })).toBe(true);
  expect(of({ AudioContext: { prototype: {} } })).toBe(false);
  expect(of({})).toBe(false);
});

it.each([
  ["does not come", () => Promise.reject(new TypeError())],
  ["breaks off", async () => ({ arrayBuffer: () => Promise.reject(new TypeError()) })],
])("keeps nobody from the page where it %s ahead", async (_what, answer) => {
  vi.stubGlobal("fetch", answer);
  await expect(loadAhead()).resolves.toBeUndefined();
});
