import { beforeEach, expect, it, vi } from "vitest";
import type { Receivers } from "../measure/report";
import type { Seat, Told } from "../messages";
import { room, seat, told } from "../testing/messages";
import type { RoomEvents } from "./livekitRoom";
import { RenditionChoice } from "./rendition";
import { Watch } from "./watch";

const { FakeRoom, rooms } = vi.hoisted(() => {
  const made: InstanceType<typeof Fake>[] = [];

  /** A stream whose newest frame the test sets. */
  class Stream {
    rtp: number | undefined;
    getSynchronizationSources = () => (this.rtp === undefined ? [] : [{ rtpTimestamp: this.rtp }]);
  }

  /** Replaces a LiveKit room; the test controls it. */
  class Fake {
    pictures = ["best 640x480", "small 320x240"];
    streams = { best: new Stream(), small: new Stream(), sound: new Stream() };
    isSubscribed = false;
    isConnected = true;
    isLeft = false;
    watched: [string | null, boolean] = [null, false];

    constructor(
      readonly seat: Seat,
      readonly events: RoomEvents,
    ) {
      made.push(this);
    }

    watch(picture: string | null, sound: boolean): void {
      this.watched = [picture, sound];
    }

    picture(name: string) {
      const kind = name.startsWith("best") ? "best" : "small";
      return name === this.watched[0] && this.isSubscribed ? this.streams[kind] : null;
    }

    get sound() {
      return this.isSubscribed ? this.streams.sound : null;
    }

    leave(): void {
      this.isLeft = true;
    }
  }

  return { FakeRoom: Fake, rooms: made };
});

vi.mock("./livekitRoom", () => ({ LiveKitRoom: FakeRoom }));

let watch: Watch;
let rendition: RenditionChoice;
let wants: { sound: boolean; picture: boolean };
let size: string;
let isExpected: boolean;
let shown: Receivers[];
let plays: boolean[];
let failures: number;
let heard: Told[];

beforeEach(() => {
  vi.useFakeTimers();
  rooms.length = 0;
  rendition = new RenditionChoice();
  wants = { sound: true, picture: true };
  size = "640x480";
  isExpected = true;
  [shown, plays, heard, failures] = [[], [], [], 0];
  watch = new Watch({
    rendition,
    wants: () => wants,
    size: () => size,
    isPictureExpected: () => isExpected,
    events: {
      show: (receivers) => shown.push(receivers),
      told: (message) => heard.push(message),
      plays: (isPlaying) => plays.push(isPlaying),
      failed: () => failures++,
    },
  });
});

function at(i: number) {
  const found = rooms[i];
  if (!found) throw new Error(`there is no room ${i}`);
  return found;
}

/** Advances time by `ms`; each stream in `moving` gets a frame every 50 ms. */
function pass(ms: number, ...moving: { rtp: number | undefined }[]): void {
  for (let passed = 0; passed < ms; passed += 50) {
    vi.advanceTimersByTime(50);
    for (const one of moving) one.rtp = (one.rtp ?? 0) + 4500;
    watch.check(performance.now());
  }
}

/** Watches the first room, whose picture has arrived. */
function begin() {
  watch.offer([seat("one"), seat("two")], performance.now());
  const first = at(0);
  first.isSubscribed = true;
  pass(100, first.streams.best);
  return first;
}

it("shows a room once its first picture has arrived, with one picture and the sound subscribed", () => {
  watch.offer([seat("one"), seat("two")], performance.now());
  at(0).isSubscribed = true;
  pass(300);
  expect(shown).toEqual([]);
  pass(50, at(0).streams.best);
  expect(shown).toEqual([{ picture: at(0).streams.best, sound: at(0).streams.sound }]);
  expect(plays).toEqual([true]);
  expect(at(0).watched).toEqual(["best 640x480", true]);
  expect(rooms).toHaveLength(1);
});

it("switches to the second room at once when the first one's signalling breaks", () => {
  const first = begin();
  first.isConnected = false;
  first.events.gone(false);
  expect(plays).toEqual([true, false]);
  expect(at(1).seat).toEqual(seat("two"));
  at(1).isSubscribed = true;
  pass(100, at(1).streams.best);
  expect(shown.at(-1)?.picture).toBe(at(1).streams.best);
  expect(plays).toEqual([true, false, true]);
});

it("switches after half a second without a picture, and keeps the old one until then", () => {
  const first = begin();
  pass(2000, first.streams.best);
  pass(450);
  expect(rooms).toHaveLength(1);
  pass(100);
  expect(at(1).seat).toEqual(seat("two"));
  expect(first.isLeft).toBe(false);
  at(1).isSubscribed = true;
  pass(100, at(1).streams.best);
  expect(first.isLeft).toBe(true);
  expect(shown).toHaveLength(2);
});

it("asks the robot's server once both fail, and uses its fresh tokens", () => {
  const first = begin();
  first.isConnected = false;
  first.events.gone(false);
  at(1).events.gone(false);
  expect(failures).toBe(1);
  expect(rooms).toHaveLength(2);
  watch.offer([seat("one"), seat("two")], performance.now());
  expect(at(2).seat).toEqual(seat("one"));
});

it("gives up a room without a picture after four seconds", () => {
  watch.offer([seat("one"), seat("two")], performance.now());
  at(0).isSubscribed = true;
  pass(3900);
  expect(rooms).toHaveLength(1);
  pass(200);
  expect(at(0).isLeft).toBe(true);
  expect(at(1).seat).toEqual(seat("two"));
});

it("tries no other room if the page was sent away", () => {
  begin().events.gone(true);
  expect(failures).toBe(1);
  expect(rooms).toHaveLength(1);
});

it("stays if the robot has no picture to send", () => {
  begin();
  isExpected = false;
  wants.sound = false;
  pass(10_000);
  expect(rooms).toHaveLength(1);
});

it("judges the room by its sound if the picture is off", () => {
  const first = begin();
  wants.picture = false;
  pass(5000, first.streams.sound);
  expect(rooms).toHaveLength(1);
  expect(shown.at(-1)?.picture).toBeNull();
  pass(600);
  expect(rooms).toHaveLength(2);
});

it("changes the rendition without leaving, and keeps the old picture until the new one arrives", () => {
  const first = begin();
  size = "320x240";
  first.isSubscribed = false;
  pass(300, first.streams.sound);
  expect(first.watched).toEqual(["small 320x240", true]);
  expect(shown.at(-1)?.picture).toBe(first.streams.best);
  first.isSubscribed = true;
  pass(600);
  expect(rooms).toHaveLength(1);
  pass(50, first.streams.small);
  expect(shown.at(-1)?.picture).toBe(first.streams.small);
});

it("rests without subscriptions, and resumes from the same room", () => {
  const first = begin();
  watch.rest();
  expect(first.watched).toEqual([null, false]);
  pass(60_000);
  expect(rooms).toHaveLength(1);
  watch.resume(performance.now());
  pass(300);
  const before = shown.length;
  pass(50, first.streams.best);
  expect(shown.length).toBeGreaterThan(before);
  expect(shown.at(-1)?.picture).toBe(first.streams.best);
  expect(first.isLeft).toBe(false);
});

it("waits as long for a resumed room as for another rendition, and shows no sound before", () => {
  const first = begin();
  watch.rest();
  first.isSubscribed = false;
  shown.length = 0;
  watch.resume(performance.now());
  pass(1800);
  first.isSubscribed = true;
  pass(100, first.streams.sound);
  expect(shown).toEqual([]);
  pass(50, first.streams.best);
  expect(rooms).toHaveLength(1);
  expect(shown).toEqual([{ picture: first.streams.best, sound: first.streams.sound }]);

  watch.rest();
  first.isSubscribed = false;
  watch.resume(performance.now());
  pass(2600);
  expect(rooms).toHaveLength(2);
});

it("stays quiet when a resting room ends", () => {
  const first = begin();
  watch.rest();
  first.isConnected = false;
  first.events.gone(false);
  expect(watch.hasRoom).toBe(false);
  expect(failures).toBe(0);
});

it("passes on messages of the playing room", () => {
  begin().events.told(told(room({})));
  expect(heard).toEqual([told(room({}))]);
});
