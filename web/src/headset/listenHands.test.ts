// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Actions } from "../actions";
import type { DriveController } from "../drive/driveController";
import { controllerOf } from "../testing/driving";
import { hello, pressedBy, room } from "../testing/messages";
import { testSession } from "../testing/session";
import type { Controller } from "./controllers";
import { type Listening, listenHands } from "./listenHands";

const [TRIGGER, SQUEEZE, STOP] = [0, 1, 5];
const FRAME_MS = 10;
const said = { stop: vi.fn(), releaseStop: vi.fn(), answerCall: vi.fn(), setAxis: vi.fn() };
let page: ReturnType<typeof testSession>;
let drive: DriveController;
let worn: EventTarget & { visibilityState: XRVisibilityState; inputSources: Controller[] };
let heard: Listening;
let ending: AbortController;

type Touch = ReturnType<typeof controller>;
function controller(handedness: "left" | "right") {
  const buttons = Array.from({ length: 7 }, () => ({ pressed: false, value: 0 }));
  const gamepad = { id: "", mapping: "xr-standard" as const, axes: [0, 0, 0, 0], buttons };
  return { handedness, gamepad };
}

function hand(side: "left" | "right"): Touch["gamepad"] {
  const found = worn.inputSources.find(({ handedness }) => handedness === side);
  if (!found?.gamepad) throw new Error(`no ${side} hand`);
  return found.gamepad as Touch["gamepad"];
}

const press = (side: "left" | "right", at: number, pressed = true) => {
  hand(side).buttons[at] = { pressed, value: Number(pressed) };
};

/** Lets the headset draw for so long. */
function frames(ms: number): void {
  for (let passed = 0; passed < ms; passed += FRAME_MS) {
    vi.advanceTimersByTime(FRAME_MS);
    heard.frame();
    heard.seen.drawn();
  }
}

/** Squeezes the left grip, then turns by the right stick. */
function turns(): void {
  frames(100);
  press("left", SQUEEZE);
  frames(100);
  hand("right").axes[2] = -1;
  frames(100);
  expect(drive.input.motion.angular).toBe(1);
}

const stopped = (is: boolean) => {
  page.state.room.value = { ...room({ operator: 1 }), stop: is ? pressedBy("Cleo") : null };
};

beforeEach(() => {
  vi.useFakeTimers();
  page = testSession();
  const { state } = page;
  state.hello.value = hello({ viewer: 1 });
  stopped(false);
  state.link.value = { is: "connected" };
  drive = controllerOf(state);
  for (const mock of Object.values(said)) mock.mockClear();
  const own: Partial<Actions> = {
    ...said,
    press: (holder, held) => drive.ways.press(holder, held),
    deflect: (holder, motion) => drive.deflect(holder, motion),
    release: (holder) => drive.ways.release(holder),
    letGo: () => drive.letGo(),
  };
  page.actions = new Proxy(page.actions, {
    get: (rest, name: keyof Actions) => own[name] ?? rest[name],
  });
  worn = Object.assign(new EventTarget(), {
    visibilityState: "visible" as const,
    inputSources: [controller("left"), controller("right")],
  });
  ending = new AbortController();
  heard = listenHands(page, worn, ending.signal);
});

afterEach(() => {
  ending.abort();
  vi.useRealTimers();
});

/** Lets time pass without a frame, in which browsers read no controllers. */
const sleeps = (ms: number) => void vi.advanceTimersByTime(ms);
const isHolding = () => drive.input.isHolding;

describe("what ends driving", () => {
  it("is a headset that draws no more, without a word of it", () => {
    turns();
    sleeps(170);
    expect(isHolding()).toBe(false);
    frames(500);
    expect(isHolding()).toBe(false);
  });

  it("is an open grip", () => {
    turns();
    press("left", SQUEEZE, false);
    frames(FRAME_MS);
    expect(isHolding()).toBe(false);
  });

  it.each(["hidden", "visible-blurred"] as const)("is a session that is %s, at once", (is) => {
    turns();
    worn.visibilityState = is;
    worn.dispatchEvent(new Event("visibilitychange"));
    expect(isHolding()).toBe(false);
    frames(100);
    worn.visibilityState = "visible";
    hand("right").axes[2] = 0;
    frames(100);
    hand("right").axes[2] = -1;
    frames(100);
    expect(isHolding()).toBe(false);
  });

  it("is the end of its session, at once", () => {
    turns();
    worn.dispatchEvent(new Event("end"));
    expect(isHolding()).toBe(false);
  });

  it.each(["left", "right"])("is the loss of the %s controller, until both are open", (lost) => {
    turns();
    const both = worn.inputSources;
    worn.inputSources = both.filter(({ handedness }) => handedness !== lost);
    frames(30);
    expect(isHolding()).toBe(false);
    worn.inputSources = both;
    frames(500);
    expect(isHolding()).toBe(false);
    hand("right").axes[2] = 0;
    press("left", SQUEEZE, false);
    turns();
  });

  it("is the end of the turn; the next one needs a new squeeze", () => {
    turns();
    page.state.room.value = room({ operator: 2 });
    expect(isHolding()).toBe(false);
    hand("right").axes[2] = 0;
    frames(100);
    page.state.room.value = room({ operator: 1, number: 9 });
    frames(100);
    hand("right").axes[2] = -1;
    frames(100);
    expect(isHolding()).toBe(false);
  });
});

it("does not drive by a grip that was squeezed before, or by a stick that rests aside", () => {
  press("left", SQUEEZE);
  frames(100);
  hand("right").axes[2] = -1;
  frames(100);
  expect(isHolding()).toBe(false);
  press("left", SQUEEZE, false);
  hand("right").axes[2] = 0.3;
  frames(100);
  press("left", SQUEEZE);
  frames(100);
  expect(isHolding()).toBe(false);
});

it("does not drive by a bare hand, and says that it sees no controller", () => {
  worn.inputSources = [{ handedness: "left" }, { handedness: "right", gamepad: undefined }];
  frames(100);
  expect(heard.grip.peek()).toEqual({ isThere: false, isSqueezed: false, isReady: false });
});

it("lets no other gamepad drive, which has no dead-man", () => {
  expect(page.actions.useGamepad).not.toHaveBeenCalled();
  page.state.pads.value = { ...page.state.pads.peek(), chosen: 0 };
  expect(page.actions.useGamepad).toHaveBeenCalledExactlyOnceWith(null);
});

it("answers a call by a trigger", () => {
  worn.dispatchEvent(new Event("selectstart"));
  expect(said.answerCall).not.toHaveBeenCalled();
  page.state.serverMs.value = 1000;
  const call = { viewer: 1, until_server_ms: 5000 };
  page.state.room.value = { ...room({ watching: [1] }), call };
  worn.dispatchEvent(new Event("selectstart"));
  expect(said.answerCall).toHaveBeenCalledTimes(1);
});

describe("Stop", () => {
  it("is for who watches, too", () => {
    page.state.room.value = room({ watching: [1] });
    press("left", STOP);
    frames(FRAME_MS);
    expect(said.stop).toHaveBeenCalledTimes(1);
  });

  it.each([
    ["left", "right"],
    ["right", "left"],
  ] as const)("is pressed by the %s hand while the %s one holds its own", (hand, other) => {
    frames(100);
    press(other, STOP);
    frames(100);
    expect(said.stop).toHaveBeenCalledTimes(1);
    press(hand, STOP);
    frames(FRAME_MS); // shorter than between two readings of a gamepad that does not drive
    press(hand, STOP, false);
    frames(100);
    expect(said.stop).toHaveBeenCalledTimes(2);
  });

  it("is not pressed by a button held since before", () => {
    ending.abort();
    press("left", STOP);
    heard = listenHands(page, worn, new AbortController().signal);
    frames(100);
    expect(said.stop).not.toHaveBeenCalled();
  });

  it("is released by a trigger that is held, of either hand", () => {
    stopped(true);
    frames(100);
    press("right", TRIGGER);
    frames(790);
    expect(said.releaseStop).not.toHaveBeenCalled();
    frames(30);
    expect(said.releaseStop).toHaveBeenCalledTimes(1);
    frames(2000);
    expect(said.releaseStop).toHaveBeenCalledTimes(1);
  });

  it("is not released by both triggers at once, when neither is held", () => {
    stopped(true);
    frames(100);
    for (const side of ["left", "right"] as const) press(side, TRIGGER);
    frames(100);
    for (const side of ["left", "right"] as const) press(side, TRIGGER, false);
    frames(2000);
    expect(said.releaseStop).not.toHaveBeenCalled();
  });

  it.each([
    ["held since before it", () => {}, () => stopped(true)],
    ["held unseen", () => stopped(true), () => sleeps(1000)],
  ])("is not released by a trigger %s", (_, before, then) => {
    frames(100);
    before();
    press("left", TRIGGER);
    frames(100);
    then();
    frames(2000);
    expect(said.releaseStop).not.toHaveBeenCalled();
  });
});

describe("the camera", () => {
  beforeEach(() => {
    const greeting = hello({ viewer: 1 });
    page.state.hello.value = { ...greeting, robot: { ...greeting.robot, axes: ["pan"] } };
    frames(100);
    press("left", SQUEEZE);
    frames(100);
    press("right", TRIGGER);
    hand("right").axes[2] = -1;
    frames(50);
    expect(said.setAxis).toHaveBeenCalled();
    expect(isHolding()).toBe(true);
    said.setAxis.mockClear();
  });

  it("is let go when nothing is drawn any more", () => {
    sleeps(170);
    expect(isHolding()).toBe(false);
  });

  it("does not jump by the time that a frame was late", () => {
    vi.spyOn(performance, "now").mockReturnValue(performance.now() + 1000); // nothing ran
    heard.frame();
    for (const [, position] of said.setAxis.mock.calls) expect(position).toBeLessThan(0.1);
    vi.restoreAllMocks();
  });
});
