// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Drive } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { hello, room } from "../testing/messages";
import { DriveController } from "./driveController";

const ADA = 1;
const BOB = 2;
const STOP = { number: 7, by: "Bob" };
const stop = vi.fn();

let state: State;
let sent: (Drive & { urgent: boolean })[];
let aborting: AbortController;
let controller: DriveController;

/** Whose page it is. */
function drives(operator: number | undefined, more: Partial<Parameters<typeof room>[0]> = {}) {
  state.room.value = room({ ...(operator && { operator }), ...more });
}

function key(type: "keydown" | "keyup", code: string): void {
  document.body.dispatchEvent(new KeyboardEvent(type, { code, bubbles: true, cancelable: true }));
}

beforeEach(() => {
  vi.useFakeTimers();
  stop.mockClear();
  sent = [];
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: ADA, command_rate_hz: 50 });
  state.link.value = { is: "connected" };
  controller = new DriveController({
    state,
    serverMs: () => 5000,
    seenServerMs: () => null,
    uplink: () => ({ linkBps: 5_000_000, waitingBytes: 0 }),
    send: (drive, urgent) => sent.push({ ...drive, urgent }),
  });
  aborting = new AbortController();
  controller.listen(window, stop, aborting.signal);
});

afterEach(() => {
  aborting.abort();
  vi.useRealTimers();
});

it("says nothing and holds nothing while somebody else drives", () => {
  drives(BOB);
  controller.input.press("a", "forward");
  controller.letGo();
  controller.paced();
  vi.advanceTimersByTime(1000);
  expect(controller.input.isHolding).toBe(false);
  expect(sent).toEqual([]);
});

it("says a press at once, as the server's room names the turn", () => {
  drives(ADA, { number: 9 });
  sent = [];
  controller.input.press("a", "forward");
  expect(sent).toMatchObject([{ turn: 9, linear: 1, held: true, urgent: false }]);
  expect(state.held.value).toEqual(new Set(["forward"]));
});

it("says a release at once and insists on it", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  sent = [];
  controller.input.release("a");
  expect(sent).toMatchObject([{ linear: 0, held: false, urgent: true }]);
  vi.advanceTimersByTime(100);
  expect(sent.filter(({ urgent }) => urgent)).toHaveLength(3);
  expect(state.held.value).toEqual(new Set());
});

it("lets go of everything, and says so three times before the task ends", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  controller.input.press("b", "left");
  sent = [];
  controller.letGo();
  const empty = sent.filter(({ urgent, held }) => urgent && !held);
  expect(empty.length).toBeGreaterThanOrEqual(3);
  expect(controller.input.isHolding).toBe(false);
});

it("begins a turn with empty input and untouched axes, and ends it with both", () => {
  drives(ADA, { number: 9 });
  controller.input.press("a", "forward");
  controller.setAxis("pan", 0.5);
  expect(state.axes.value).toEqual({ pan: 0.5 });
  sent = [];
  drives(ADA, { number: 10 });
  expect(controller.input.isHolding).toBe(false);
  expect(state.axes.value).toEqual({});
  expect(sent[0]).toMatchObject({ turn: 9, held: false });
  expect(sent.at(-1)).toMatchObject({ turn: 10, held: false, axes: {} });

  controller.input.press("a", "forward");
  controller.setAxis("pan", 0.5);
  sent = [];
  drives(BOB, { number: 11 });
  expect(sent).toMatchObject([{ turn: 10, held: false }]);
  expect(state.axes.value).toEqual({});
  vi.advanceTimersByTime(1000);
  expect(sent).toHaveLength(1);
});

it("falls silent when the link is lost, and asks for a new press when it is back", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  state.link.value = { is: "connecting", reason: null };
  sent = [];
  vi.advanceTimersByTime(1000);
  expect(sent).toEqual([]);
  state.link.value = { is: "connected" };
  expect(sent.map(({ held }) => held)).toEqual([false]);
  controller.input.press("a", "forward");
  expect(sent.at(-1)?.held).toBe(true);
});

it("empties the input for a stop, which nothing is held through", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  sent = [];
  drives(ADA, { stop: STOP });
  expect(sent[0]).toMatchObject({ held: false, urgent: true });
  controller.input.press("a", "forward");
  expect(controller.input.isHolding).toBe(false);
  drives(ADA);
  expect(controller.input.isHolding).toBe(false);
  controller.input.press("a", "forward");
  expect(sent.at(-1)).toMatchObject({ linear: 1, held: true });
});

it("tells the operator that a stop was released, until the first press", () => {
  drives(ADA);
  expect(state.isFreshlyReleased.value).toBe(false);
  drives(ADA, { stop: STOP });
  expect(state.isFreshlyReleased.value).toBe(false);
  drives(ADA);
  expect(state.isFreshlyReleased.value).toBe(true);
  controller.input.press("a", "forward");
  expect(state.isFreshlyReleased.value).toBe(false);
});

it("tells nobody else", () => {
  drives(BOB, { stop: STOP });
  drives(BOB);
  expect(state.isFreshlyReleased.value).toBe(false);
});

it("says the chosen speed at once", () => {
  drives(ADA);
  state.preferences.value = { ...state.preferences.value, speed: "fast" };
  sent = [];
  controller.paced();
  expect(sent).toMatchObject([{ speed: "fast", held: false }]);
});

it("lets go after the page hung, before it says anything", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  sent = [];
  const nowMs = performance.now();
  vi.spyOn(performance, "now").mockReturnValue(nowMs + 1000);
  vi.advanceTimersToNextTimer();
  expect(sent.length).toBeGreaterThan(0);
  expect(sent.some(({ held }) => held)).toBe(false);
});

it("drives by the keyboard, stops by Space, and lets go when the window is left", () => {
  drives(BOB);
  key("keydown", "Space");
  key("keyup", "Space");
  expect(stop).not.toHaveBeenCalled();
  drives(ADA);
  key("keydown", "ArrowUp");
  expect(sent.at(-1)).toMatchObject({ linear: 1, held: true });
  key("keydown", "Space");
  expect(stop).toHaveBeenCalledOnce();
  window.dispatchEvent(new Event("blur"));
  expect(sent.at(-1)).toMatchObject({ linear: 0, held: false, urgent: true });
});

it("releases what a finger holds, wherever it is lifted", () => {
  drives(ADA);
  controller.input.press("pointer 3", "forward");
  window.dispatchEvent(new PointerEvent("pointerup", { pointerId: 3 }));
  expect(sent.at(-1)).toMatchObject({ linear: 0, held: false, urgent: true });
});
