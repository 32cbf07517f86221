// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Drive } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { controllerOf } from "../testing/driving";
import { loadGamepads, pad, plugIn, push, readings, takeAwayGamepads } from "../testing/gamepads";
import { control, hello, planar, pressedBy, room } from "../testing/messages";
import type { DriveController } from "./driveController";

const ADA = 1;
const BOB = 2;
const STOP = pressedBy("Bob", { number: 7 });
const stop = vi.fn();
const releaseStop = vi.fn();
const toggleSpeed = vi.fn();
const tellOfPad = vi.fn();

let state: State;
let sent: (Drive & { urgent: boolean })[];
let aborting: AbortController;
let controller: DriveController;

/** Whose page it is. */
function drives(operator: number | undefined, more: Partial<Parameters<typeof room>[0]> = {}) {
  state.room.value = room({ ...(operator && { operator }), ...more });
}

function key(type: "keydown" | "keyup", code: string, shiftKey = false): void {
  const told = { code, shiftKey, bubbles: true, cancelable: true };
  document.body.dispatchEvent(new KeyboardEvent(type, told));
}

beforeEach(() => {
  vi.useFakeTimers();
  for (const action of [stop, releaseStop, toggleSpeed, tellOfPad]) action.mockClear();
  sent = [];
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: ADA, command_rate_hz: 50 });
  state.link.value = { is: "connected" };
  controller = controllerOf(state, {
    send: (drive, urgent) => sent.push({ ...drive, urgent }),
  });
  aborting = new AbortController();
  controller.listen(window, { stop, releaseStop, toggleSpeed, tellOfPad }, aborting.signal);
});

afterEach(() => {
  aborting.abort();
});

it("sends and holds nothing while somebody else drives", () => {
  drives(BOB);
  controller.input.press("a", "forward");
  controller.letGo();
  controller.speedChanged();
  vi.advanceTimersByTime(1000);
  expect(controller.input.isHolding).toBe(false);
  expect(sent).toEqual([]);
});

it("sends a press at once, with the turn from the room state", () => {
  drives(ADA, { number: 9 });
  sent = [];
  controller.input.press("a", "forward");
  expect(sent).toMatchObject([{ turn: 9, linear: 1, held: true, urgent: false }]);
  expect(state.held.value).toEqual(new Set(["forward"]));
});

describe("sideways", () => {
  const pressesAll = async () => {
    await loadGamepads();
    key("keydown", "KeyQ");
    key("keydown", "ArrowLeft", true);
    const mine = pad({ axes: [0, 0, 0, 0] });
    plugIn([mine]);
    controller.useGamepad(0);
    readings(2);
    mine.axes[0] = -1;
    push(mine, 4);
    readings(2);
    takeAwayGamepads();
  };

  it("is in no message to a robot that cannot, whatever is pressed", async () => {
    drives(ADA);
    await pressesAll();
    expect(sent.at(-1)).toMatchObject({ held: true, angular: 1 });
    expect(sent.some((one) => "lateral" in one)).toBe(false);
    expect(state.held.value).toEqual(new Set(["left"]));
  });

  it("is in each message to a robot that can", async () => {
    state.hello.value = planar(hello({ viewer: ADA, command_rate_hz: 50 }));
    drives(ADA);
    expect(sent.at(-1)).toMatchObject({ lateral: 0, held: false });
    await pressesAll();
    expect(sent.at(-1)).toMatchObject({ lateral: 1, angular: 0, held: true });
    expect(state.held.value).toEqual(new Set(["lateral_left"]));
    key("keyup", "KeyQ");
    controller.letGo();
    expect(sent.at(-1)).toMatchObject({ lateral: 0, held: false, urgent: true });
  });

  it("leaves its keys to the host's controls on a robot that cannot, and takes them on one that can", () => {
    const greeting = hello({ viewer: ADA, controls: [control("horn", { key: "KeyQ" })] });
    for (const [mine, held] of [
      [greeting, ["horn"]],
      [planar(greeting), []],
    ] as const) {
      state.hello.value = mine;
      drives(ADA);
      key("keydown", "KeyQ");
      expect([...state.heldControls.value]).toEqual(held);
      key("keyup", "KeyQ");
      drives(BOB);
    }
  });

  it("is a short, slow move in steps", () => {
    state.hello.value = planar(hello({ viewer: ADA, command_rate_hz: 50 }));
    state.preferences.value = { ...state.preferences.value, way: "step", speed: "fast" };
    drives(ADA);
    key("keydown", "KeyE");
    expect(sent.at(-1)).toMatchObject({ lateral: -1, speed: "slow", held: true });
    vi.advanceTimersByTime(state.preferences.value.stepMs);
    expect(sent.at(-1)).toMatchObject({ lateral: 0, held: false });
  });
});

it("sends a release at once and repeats it", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  sent = [];
  controller.input.release("a");
  expect(sent).toMatchObject([{ linear: 0, held: false, urgent: true }]);
  vi.advanceTimersByTime(100);
  expect(sent.filter(({ urgent }) => urgent)).toHaveLength(3);
  expect(state.held.value).toEqual(new Set());
});

it("releases everything, and sends that three times before the task ends", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  controller.input.press("b", "left");
  sent = [];
  controller.letGo();
  const empty = sent.filter(({ urgent, held }) => urgent && !held);
  expect(empty.length).toBeGreaterThanOrEqual(3);
  expect(controller.input.isHolding).toBe(false);
});

it("starts and ends a turn with nothing held and no axis touched", () => {
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

it("falls silent when the link is lost, and needs a new press when it is back", () => {
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

it("releases everything for a stop", () => {
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

it("tells the operator that a stop was released until the first press", () => {
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

it("sends the chosen speed at once", () => {
  drives(ADA);
  state.preferences.value = { ...state.preferences.value, speed: "fast" };
  sent = [];
  controller.speedChanged();
  expect(sent).toMatchObject([{ speed: "fast", held: false }]);
});

it("releases everything after the page hung, before it sends anything", () => {
  drives(ADA);
  controller.input.press("a", "forward");
  sent = [];
  const nowMs = performance.now();
  vi.spyOn(performance, "now").mockReturnValue(nowMs + 1000);
  vi.advanceTimersToNextTimer();
  expect(sent.length).toBeGreaterThan(0);
  expect(sent.some(({ held }) => held)).toBe(false);
});

it("drives by keyboard, stops by Space, and releases when the window loses the focus", () => {
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

/** A robot with a camera that pans and tilts, driven by this page. */
function drivesWith(preferences: Partial<State["preferences"]["value"]>, axes: string[] = []) {
  const mine = hello({ viewer: ADA, command_rate_hz: 50 });
  state.hello.value = { ...mine, robot: { ...mine.robot, axes } };
  state.preferences.value = { ...state.preferences.value, ...preferences };
  drives(ADA);
}

it("sends a stick's deflection", () => {
  drives(ADA);
  controller.ways.press("stick", { linear: 0, angular: 0 });
  expect(sent.at(-1)).toMatchObject({ linear: 0, angular: 0, held: true });
  expect(controller.deflect("stick", { linear: 0.25, angular: -0.5 })).toBe(true);
  expect(sent.at(-1)).toMatchObject({ linear: 0.25, angular: -0.5, held: true });
  expect(state.motion.value).toEqual({ linear: 0.25, angular: -0.5 });
  expect(state.isHolding.value).toBe(true);
  controller.ways.release("stick");
  expect(state.motion.value).toEqual({ linear: 0, angular: 0 });
  expect(state.isHolding.value).toBe(false);
});

it("sends a step as slow at any speed", () => {
  drivesWith({ way: "step", speed: "fast", stepMs: 400 });
  key("keydown", "ArrowUp");
  expect(sent.at(-1)).toMatchObject({ linear: 1, held: true, speed: "slow" });
  vi.advanceTimersByTime(500);
  expect(sent.at(-1)).toMatchObject({ linear: 0, held: false, speed: "fast" });
});

it("falls back to holding if the host does not allow clicks", () => {
  drivesWith({ way: "click" });
  controller.ways.press("a", "forward");
  controller.ways.release("a");
  expect(sent.at(-1)?.held).toBe(false);
});

it("moves the axes by keys, and centres them all by one key", () => {
  drivesWith({}, ["pan", "tilt"]);
  key("keydown", "KeyJ");
  key("keydown", "KeyK");
  vi.advanceTimersByTime(450);
  expect(state.axes.value.pan).toBeCloseTo(0.5, 10);
  expect(state.axes.value.tilt).toBeCloseTo(-0.5, 10);
  key("keyup", "KeyJ");
  key("keyup", "KeyK");
  key("keydown", "KeyO");
  expect(state.axes.value).toEqual({ pan: 0, tilt: 0 });
  expect(sent.at(-1)).toMatchObject({ held: true, linear: 0 });
  vi.advanceTimersByTime(400);
  expect(sent.at(-1)).toMatchObject({ held: false });
});

it("has no axes before the robot has reported them", () => {
  state.hello.value = null;
  controller.recentre();
  expect(state.axes.value).toEqual({});
});

it("offers directions to a switch only while this page drives by scanning", () => {
  controller.scan("select");
  drivesWith({ way: "scan", dwellMs: 1000 });
  expect(state.scan.value).toBe("forward");
  vi.advanceTimersByTime(1000);
  expect(state.scan.value).toBe("left");
  controller.scan("select");
  expect(sent.at(-1)).toMatchObject({ angular: 1, held: true, speed: "slow" });
  drives(BOB);
  expect(state.scan.value).toBeNull();
});

it("stops by a switch, then offers only the release", () => {
  drivesWith({ way: "scan", switches: 2 });
  for (const _ of ["left", "right", "back", "stop"]) tap("KeyN");
  expect(state.scan.value).toBe("stop");
  vi.advanceTimersByTime(60_000);
  tap("Enter");
  expect(stop).toHaveBeenCalledOnce();
  drives(ADA, { stop: STOP });
  expect(state.scan.value).toBe("release");
  controller.scan("next");
  controller.scan("select");
  expect(releaseStop).toHaveBeenCalledOnce();
  state.preferences.value = { ...state.preferences.value, way: "hold" };
  expect(state.scan.value).toBeNull();
});

it("drives by a chosen gamepad, and shows its state", async () => {
  const mine = pad();
  vi.spyOn(document, "hasFocus").mockReturnValue(true);
  controller.useGamepad(0);
  expect(state.pads.value.chosen).toBeNull();
  plugIn([mine]);
  await vi.dynamicImportSettled();
  expect(tellOfPad).toHaveBeenCalledExactlyOnceWith("found");
  drives(ADA);
  controller.useGamepad(0);
  readings(2);
  expect(state.pads.value).toMatchObject({ chosen: 0, isReady: true });
  readings(20);
  expect(controller.padRestNow()).toEqual([0, 0, 0]);
  controller.learnPad(null);
  mine.axes[1] = -0.8;
  readings(2);
  expect(sent.at(-1)?.linear).toBeGreaterThan(0.3);
  expect(sent.at(-1)?.linear).toBeLessThan(1);
  push(mine, 1);
  readings(2);
  expect(stop).toHaveBeenCalledOnce();
  aborting.abort();
  readings(2);
  takeAwayGamepads();
});

it("can be called before it listens", () => {
  const uplink = { linkBps: null, waitingBytes: 0, queuedMs: 0 };
  const another = controllerOf(state, { uplink: () => uplink });
  another.useGamepad(0);
  another.learnPad(null);
  another.scan("select");
  expect(another.padRestNow()).toBeNull();
  expect(state.pads.value.chosen).toBeNull();
  expect(another.uplink()).toEqual(uplink);
});

/** Presses and releases a key. */
function tap(code: string): void {
  key("keydown", code);
  key("keyup", code);
}
