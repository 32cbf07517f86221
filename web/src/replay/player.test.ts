// @vitest-environment dom
import { beforeEach, expect, it, vi } from "vitest";
import type { Placed, TapeContent } from "../messages";
import { Player } from "./player";
import { Timeline } from "./timeline";

/** An element that plays nothing; tests set its position. */
function element(tag: "video" | "audio"): HTMLVideoElement & HTMLAudioElement {
  const made = document.createElement(tag) as HTMLVideoElement & HTMLAudioElement;
  let isPaused = true;
  Object.defineProperties(made, {
    currentTime: { value: 0, writable: true },
    paused: { get: () => isPaused },
    ended: { value: false, writable: true },
    playbackRate: { value: 1, writable: true },
  });
  made.load = vi.fn();
  made.play = vi.fn(async () => {
    isPaused = false;
  });
  made.pause = vi.fn(() => {
    isPaused = true;
  });
  return made;
}

const TURN = { type: "turned", number: 1, operator: 1, why: null } as const;

function content(more: Partial<TapeContent> = {}): TapeContent {
  const events: Placed[] = [{ at_ms: 0, event: TURN }];
  for (let at_ms = 0; at_ms <= 20_000; at_ms += 1000) {
    const watched = { type: "watched", viewer: 1, picture_ms: 300, sound_ms: 500 };
    events.push({ at_ms, event: watched as unknown as Placed["event"] });
  }
  return {
    name: "the fall",
    began_wall_ms: 0,
    length_ms: 20_000,
    has_media: true,
    has_picture: true,
    has_sound: true,
    cameras: [],
    events,
    problem: null,
    ...more,
  };
}

let picture: ReturnType<typeof element>;
let sound: ReturnType<typeof element>;
let player: Player;
const timeline = new Timeline(content());

beforeEach(() => {
  picture = element("video");
  sound = element("audio");
  player = new Player(picture, sound);
  player.load(content());
});

it("plays picture and sound of one element as it was", async () => {
  expect(picture.src).toContain("media/the%20fall");
  await player.play();
  player.follow(timeline);
  expect(picture.muted).toBe(false);
  expect(sound.paused).toBe(true);
  player.seek(5000, timeline);
  expect(picture.currentTime).toBe(5);
  expect(player.momentMs(timeline)).toBe(5000);
});

it("shows the picture and plays the sound that the operator had at a moment", async () => {
  player.view = "seen";
  player.seek(5000, timeline);
  expect(picture.currentTime).toBeCloseTo(4.7);
  expect(player.momentMs(timeline)).toBeCloseTo(5000);
  await player.play();
  player.follow(timeline);
  expect(picture.muted).toBe(true);
  expect(sound.paused).toBe(false);
  expect(sound.currentTime).toBeCloseTo(4.5);
});

it("keeps the sound in step by its speed, and seeks only if it is far off", async () => {
  player.view = "seen";
  player.rate = 0.5;
  player.seek(5000, timeline);
  await player.play();
  player.follow(timeline);
  sound.currentTime = 4.45;
  player.follow(timeline);
  expect(sound.currentTime).toBe(4.45);
  expect(sound.playbackRate).toBeCloseTo(0.52);
  sound.currentTime = 3;
  player.follow(timeline);
  expect(sound.currentTime).toBeCloseTo(4.5);
});

it("keeps a camera that began later in step", async () => {
  const camera = element("video");
  Object.defineProperty(camera, "duration", { value: 8 });
  const letGo = player.attach(camera, 2000);
  player.seek(5000, timeline);
  expect(camera.currentTime).toBe(3);
  await player.play();
  player.rate = 0.5;
  player.follow(timeline);
  expect(camera.paused).toBe(false);
  expect(camera.playbackRate).toBe(0.5);
  player.pause();
  camera.currentTime = 3.01;
  player.follow(timeline);
  expect(camera.paused).toBe(true);
  expect(camera.currentTime).toBe(3);
  player.seek(1000, timeline);
  expect(camera.currentTime).toBe(0);
  player.seek(15_000, timeline);
  expect(camera.currentTime).toBe(8);
  letGo();
  player.seek(5000, timeline);
  expect(camera.currentTime).toBe(8);
});

it("pauses a camera that has not begun or has died", async () => {
  const camera = element("video");
  Object.defineProperty(camera, "duration", { value: 8 });
  player.attach(camera, 2000);
  player.seek(1000, timeline);
  await player.play();
  player.follow(timeline);
  expect(camera.paused).toBe(true);
  picture.currentTime = 2.1;
  player.follow(timeline);
  expect(camera.paused).toBe(false);
  picture.currentTime = 11;
  player.follow(timeline);
  expect(camera.paused).toBe(true);
});

it("keeps a camera in step by its speed, and seeks only if it is far off", async () => {
  const camera = element("video");
  player.attach(camera, 0);
  player.seek(5000, timeline);
  await player.play();
  camera.currentTime = 4.5;
  player.follow(timeline);
  expect(camera.currentTime).toBe(4.5);
  expect(camera.playbackRate).toBeCloseTo(1.15);
  camera.currentTime = 3;
  player.follow(timeline);
  expect(camera.currentTime).toBe(5);
});

it("advances time without picture and sound", async () => {
  vi.useFakeTimers({ toFake: ["performance"] });
  player.load(content({ has_media: false }));
  expect(player.isPlaying).toBe(false);
  await player.play();
  vi.advanceTimersByTime(2000);
  expect(player.mediaMs).toBe(2000);
  player.rate = 0.5;
  vi.advanceTimersByTime(2000);
  expect(player.mediaMs).toBe(3000);
  player.pause();
  vi.advanceTimersByTime(2000);
  expect(player.mediaMs).toBe(3000);
  player.seek(19_000, timeline);
  await player.play();
  vi.advanceTimersByTime(9000);
  expect(player.hasEnded).toBe(true);
});
