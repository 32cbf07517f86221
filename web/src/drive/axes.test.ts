// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Drive, RoomState } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { controllerOf } from "../testing/driving";
import { hello, pressedBy, room } from "../testing/messages";
import type { DriveController } from "./driveController";

interface Word {
  held: boolean;
  axes: Drive["axes"];
}

const STOP = pressedBy("Bob", { number: 3 });
const NOTHING = { held: false, axes: {} };

let state: State;
let sent: Drive[];
let controller: DriveController;
let listening: AbortController;

/** A page that drives in turn 7 with everything released. */
beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  state = createState(loadPreferences(null));
  controller = controllerOf(state, {
    seenServerMs: () => 4900,
    send: (drive) => sent.push(drive),
  });
  listening = new AbortController();
  const stop = () => {};
  controller.listen(
    window,
    { stop, releaseStop: stop, toggleSpeed: stop, tellOfPad: stop },
    listening.signal,
  );
  state.hello.value = hello({ viewer: 1 });
  state.link.value = { is: "connected" };
  drives(7);
  vi.advanceTimersByTime(1000);
});

afterEach(() => {
  listening.abort();
});

function drives(number: number, stop: RoomState["stop"] = null): void {
  state.room.value = room({ operator: 1, number, stop });
}

/** What was sent meanwhile: whether anything was held, and which axes were named. */
function said(during: () => void): Word[] {
  const before = sent.length;
  during();
  return sent.slice(before).map(({ held, axes }) => ({ held, axes }));
}

/** The next second, in which 20 set-points are sent even with nothing held. */
function inTheNextSecond(): Word[] {
  const words = said(() => vi.advanceTimersByTime(1000));
  expect(words.length).toBeGreaterThanOrEqual(20);
  return words;
}

it("holds an axis while its slider changes and a moment longer, and sends that at once", () => {
  const pan = (to: number) => ({ held: true, axes: { pan: to } });
  expect(said(() => controller.setAxis("pan", 0.5))).toEqual([pan(0.5)]);
  expect(sent.at(-1)).toMatchObject({ linear: 0, angular: 0 });
  expect(state.held.value.size).toBe(0);
  controller.setAxis("pan", 0.6);
  const words = said(() => vi.advanceTimersByTime(299));
  expect(words.length).toBeGreaterThanOrEqual(6);
  for (const word of words) expect(word).toEqual(pan(0.6));
  for (const word of inTheNextSecond()) expect(word).toEqual(NOTHING);
  expect(state.axes.value).toEqual({ pan: 0.6 });
});

it("sends only the touched axis of two", () => {
  controller.setAxis("pan", 0.5);
  vi.advanceTimersByTime(1000);
  expect(said(() => controller.setAxis("tilt", -1))).toEqual([{ held: true, axes: { tilt: -1 } }]);
});

it("names no axis for input that only drives", () => {
  controller.setAxis("pan", 0.5);
  vi.advanceTimersByTime(1000);
  expect(said(() => controller.input.press("a", "forward"))).toEqual([{ held: true, axes: {} }]);
});

it("sends nothing of a slider moved during a stop, neither then nor later", () => {
  drives(7, STOP);
  const words = said(() => {
    controller.setAxis("pan", 0.5);
    vi.advanceTimersByTime(100);
    drives(7);
  });
  for (const word of [...words, ...inTheNextSecond()]) expect(word).toEqual(NOTHING);
});

it.each([
  ["a stop", () => drives(7, STOP)],
  ["another turn", () => drives(8)],
  ["the loss of the keyboard", () => void window.dispatchEvent(new Event("blur"))],
])("lets go of the axes by %s", (_, lose) => {
  controller.setAxis("pan", 0.5);
  const words = said(lose);
  expect(words.length).toBeGreaterThanOrEqual(1);
  for (const word of [...words, ...inTheNextSecond()]) expect(word).toEqual(NOTHING);
});
