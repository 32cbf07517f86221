import { beforeEach, describe, expect, it, vi } from "vitest";
import { pageSentence, said, says } from "../words/said";
import { ENCODINGS, type Uplink } from "./encoding";
import { type Microphone, MicrophoneError } from "./microphone";
import { SILENT, Talk, type Voice } from "./talk";

const WIDE: Uplink = { linkBps: 5_000_000, waitingBytes: 0, roundTripMs: 40, commandHz: 20 };

class FakeMicrophone {
  track = {} as MediaStreamTrack;
  level = 0.5;
  close = vi.fn();
}

function connection() {
  return { speak: vi.fn(async (_: MediaStreamTrack | null) => {}), shape: vi.fn() };
}

let link: ReturnType<typeof connection> | null;
let uplink: Uplink;
let voice: Voice;
let made: FakeMicrophone[];
let open: ReturnType<typeof vi.fn>;
let gone: (sentence: string) => void;
let duck: ReturnType<typeof vi.fn>;
let soundMs: number;
let talk: Talk;

beforeEach(() => {
  vi.useFakeTimers();
  link = connection();
  uplink = WIDE;
  voice = SILENT;
  made = [];
  open = vi.fn(async (onGone: typeof gone) => {
    gone = onGone;
    const one = new FakeMicrophone();
    made.push(one);
    return one as unknown as Microphone;
  });
  duck = vi.fn();
  soundMs = 100;
  talk = new Talk({
    link: () => link,
    uplink: () => uplink,
    changed: (now) => {
      voice = now;
    },
    soundMs: () => soundMs,
    duck: duck as (isDucked: boolean) => void,
    open: open as unknown as typeof Microphone.open,
  });
  talk.allow(true);
});

/** What was sent last: a track or null; undefined if nothing ever was. */
const sent = () => link?.speak.mock.lastCall?.[0];

async function press(holder = "finger 1"): Promise<void> {
  talk.press(holder);
  await vi.advanceTimersByTimeAsync(0);
}

it("sends nothing before it is pressed, and opens no microphone", async () => {
  for (let ms = 0; ms < 1000; ms += 200) talk.adapt(ms);
  await vi.advanceTimersByTimeAsync(1000);
  expect(open).not.toHaveBeenCalled();
  expect(link?.speak).not.toHaveBeenCalled();
});

it("says after 4 s that the browser has not given the microphone, and goes on once it has", async () => {
  let give = (_: unknown) => {};
  open.mockReturnValueOnce(new Promise((resolve) => (give = resolve)));
  await press();
  await vi.advanceTimersByTimeAsync(3999);
  expect(voice.problem).toBeNull();
  await vi.advanceTimersByTimeAsync(1);
  expect(said(voice.problem)).toContain("does not answer (getUserMedia)");
  give(new FakeMicrophone());
  await vi.advanceTimersByTimeAsync(0);
  expect(voice).toMatchObject({ isOn: true, problem: null });
});

it("speaks while it is held, and shows the level", async () => {
  await press();
  expect(sent()).toBe(made[0]?.track);
  expect(voice.isOn).toBe(true);
  await vi.advanceTimersByTimeAsync(100);
  expect(voice.level).toBe(0.5);
  expect(talk.release("finger 1")).toBe(true);
  expect(sent()).toBeNull();
  expect(voice).toMatchObject({ isOn: false, level: 0 });
});

it("speaks until the last holder releases", async () => {
  await press("finger 1");
  await press("key KeyT");
  talk.release("finger 1");
  expect(sent()).toBe(made[0]?.track);
  talk.release("key KeyT");
  expect(sent()).toBeNull();
});

it("is silent if it was released while the user was asked", async () => {
  talk.press("finger 1");
  expect(voice.isOpening).toBe(true);
  talk.release("finger 1");
  await vi.advanceTimersByTimeAsync(0);
  expect(voice).toMatchObject({ isOpening: false, isOn: false });
  expect(link?.speak).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(30_000);
  expect(made[0]?.close).toHaveBeenCalled();
});

it("releases the microphone half a minute after the last use", async () => {
  await press();
  talk.release("finger 1");
  await vi.advanceTimersByTimeAsync(20_000);
  await press();
  talk.release("finger 1");
  expect(open).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(30_000);
  expect(made[0]?.close).toHaveBeenCalledTimes(1);
  await press();
  expect(open).toHaveBeenCalledTimes(2);
});

it("is silent at once when the turn is over, whatever is held", async () => {
  await press();
  talk.keepOpen(true);
  talk.allow(false);
  expect(sent()).toBeNull();
  expect(voice).toMatchObject({ isOn: false, isKept: false });
  await press("finger 2");
  talk.allow(true);
  expect(voice.isOn).toBe(false);
});

it("releases what is held, but not an open microphone", async () => {
  talk.keepOpen(true);
  await press();
  talk.letGo();
  expect(voice).toMatchObject({ isOn: true, isKept: true });
  talk.keepOpen(false);
  expect(voice.isOn).toBe(false);
});

it("continues over the next connection", async () => {
  await press();
  link = connection();
  talk.reconnected();
  expect(sent()).toBe(made[0]?.track);
});

describe("an error is shown as a sentence", () => {
  it("a microphone that is refused", async () => {
    open.mockRejectedValueOnce(new MicrophoneError("The microphone is not allowed here."));
    await press();
    expect(voice).toMatchObject({
      isOn: false,
      problem: says("The microphone is not allowed here."),
    });
    await press();
    expect(voice).toMatchObject({ isOn: true, problem: null });
  });

  it("a microphone that vanishes", async () => {
    await press();
    gone("The microphone has gone; plug it in again.");
    expect(sent()).toBeNull();
    expect(voice).toMatchObject({
      isOn: false,
      problem: says("The microphone has gone; plug it in again."),
    });
    await press();
    expect(open).toHaveBeenCalledTimes(2);
  });

  it("a link without room for both, where commands have priority", async () => {
    await press();
    uplink = { ...WIDE, linkBps: 50_000 };
    talk.adapt(1000);
    expect(sent()).toBeNull();
    expect(voice).toMatchObject({ isOn: true, problem: pageSentence("voice.no_room") });
    uplink = WIDE;
    talk.adapt(2000);
    expect(sent()).toBe(made[0]?.track);
    expect(voice.problem).toBeNull();
  });

  it("the server's refusal", async () => {
    await press();
    talk.reported(true, null);
    expect(voice.isHeard).toBe(true);
    talk.reported(false, says("Bob is speaking; wait until they have finished."));
    expect(voice.isHeard).toBe(false);
    expect(said(voice.problem)).toMatch(/^Bob is speaking/);
  });
});

it("uses the encoding that the link allows", async () => {
  uplink = { ...WIDE, linkBps: 300_000 };
  talk.adapt(0);
  await press();
  expect(link?.shape).toHaveBeenLastCalledWith(ENCODINGS[1]);
});

describe("the robot is muted", () => {
  it("while the button is held", async () => {
    await press();
    expect(duck).toHaveBeenLastCalledWith(true);
    talk.release("finger 1");
    await vi.advanceTimersByTimeAsync(499);
    expect(duck).toHaveBeenLastCalledWith(true);
    await vi.advanceTimersByTimeAsync(1);
    expect(duck).toHaveBeenLastCalledWith(false);
  });

  it("until the echo of the last word has passed, for a bounded time", async () => {
    soundMs = 400;
    uplink = { ...WIDE, roundTripMs: 200 };
    await press();
    talk.release("finger 1");
    await vi.advanceTimersByTimeAsync(1199);
    expect(duck).toHaveBeenLastCalledWith(true);
    await press();
    await vi.advanceTimersByTimeAsync(5000);
    expect(duck).toHaveBeenLastCalledWith(true);
    soundMs = 9000;
    talk.release("finger 1");
    await vi.advanceTimersByTimeAsync(2499);
    expect(duck).toHaveBeenLastCalledWith(true);
    await vi.advanceTimersByTimeAsync(1);
    expect(duck).toHaveBeenLastCalledWith(false);
  });

  it("with an open microphone only while the user speaks or the robot plays it", async () => {
    talk.keepOpen(true);
    await vi.advanceTimersByTimeAsync(0);
    const [device] = made;
    if (!device) throw new Error("no microphone was opened");
    device.level = 0.1;
    await vi.advanceTimersByTimeAsync(100);
    expect(duck).not.toHaveBeenCalled();
    device.level = 0.5;
    await vi.advanceTimersByTimeAsync(100);
    expect(duck).toHaveBeenLastCalledWith(true);
    device.level = 0.1;
    await vi.advanceTimersByTimeAsync(600);
    expect(duck).toHaveBeenLastCalledWith(false);
    talk.reported(true, null);
    expect(duck).toHaveBeenLastCalledWith(true);
    talk.reported(false, null);
    await vi.advanceTimersByTimeAsync(500);
    expect(duck).toHaveBeenLastCalledWith(false);
  });

  it("but not if nothing of the voice is played", async () => {
    await press();
    talk.reported(false, says("The host has muted all voices."));
    await vi.advanceTimersByTimeAsync(500);
    expect(duck).toHaveBeenLastCalledWith(false);
  });
});
