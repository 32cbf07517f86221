import { beforeEach, expect, it, vi } from "vitest";
import { Playback } from "./playback";
import { eventually } from "./testing/eventually";

/** A media element that plays and pauses, also by the system. */
class Element extends EventTarget {
  paused = true;
  ended = false;
  muted = false;
  volume = 1;
  srcObject: unknown = null;
  play = vi.fn(async () => this.isNow(false));
  pause = vi.fn(() => this.isNow(true));
  isNow(paused: boolean): void {
    if (paused === this.paused) return;
    this.paused = paused;
    this.dispatchEvent(new Event(paused ? "pause" : "play"));
  }
}

const silenced = vi.fn();
const resumed = vi.fn();
let element: Element;
let playback: Playback;

beforeEach(() => {
  vi.clearAllMocks();
  element = new Element();
  playback = new Playback({ silenced, resumed });
  playback.attach(element as unknown as HTMLMediaElement);
});

it("reports when a call pauses the sound, and when it resumes", () => {
  playback.play();
  element.isNow(true);
  expect(silenced).toHaveBeenCalledOnce();
  expect(element.pause).not.toHaveBeenCalled();
  expect(resumed).not.toHaveBeenCalled();
  element.isNow(false);
  expect(resumed).toHaveBeenCalledOnce();
  element.isNow(true);
  expect(silenced).toHaveBeenCalledTimes(2);
});

it("resumes a muted element, such as the picture, as soon as the system allows it", () => {
  vi.useFakeTimers();
  element.muted = true;
  playback.play();
  element.play.mockReturnValueOnce(new Promise(() => {}));
  element.isNow(true);
  expect(element.play).toHaveBeenCalledTimes(2);
  expect(element.paused).toBe(true);
  vi.advanceTimersByTime(1000);
  expect(element.paused).toBe(false);
  vi.advanceTimersByTime(5000);
  expect(element.play).toHaveBeenCalledTimes(3);
  expect(silenced).not.toHaveBeenCalled();
  vi.useRealTimers();
});

it("reports nothing for the page's own pause, an ended sound, or another element", () => {
  playback.play();
  playback.pause();
  playback.play();
  element.ended = true;
  element.isNow(true);
  element.ended = false;
  playback.attach(null);
  element.isNow(false);
  element.isNow(true);
  expect(silenced).not.toHaveBeenCalled();
  expect(resumed).not.toHaveBeenCalled();
});

it.each([
  ["NotAllowedError", 1],
  ["AbortError", 0],
])("demands a touch where the browser does (%s)", async (name, times) => {
  element.play.mockRejectedValueOnce(new DOMException("", name));
  playback.play();
  await eventually(() => expect(silenced).toHaveBeenCalledTimes(times));
  playback.play();
  expect(element.paused).toBe(false);
  expect(resumed).not.toHaveBeenCalled();
});
