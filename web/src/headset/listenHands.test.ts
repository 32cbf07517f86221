import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { InputState } from "../drive/inputState";
import type { State } from "../state";
import { hello, pressedBy, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { listenHands } from "./listenHands";

const SQUEEZE = 1;
const STOP = 5;
let state: State;
let input: InputState;
let session: EventTarget & { visibilityState: XRVisibilityState; inputSources: Touch[] };
let seen: ReturnType<typeof listenHands>["seen"];
let ending: AbortController;
const acted = { letGo: vi.fn(), stop: vi.fn(), releaseStop: vi.fn(), answerCall: vi.fn() };

type Touch = ReturnType<typeof touch>;
function touch(handedness: "left" | "right") {
  const buttons = Array.from({ length: 7 }, () => ({ pressed: false, value: 0 }));
  const gamepad = { id: "", mapping: "xr-standard" as const, axes: [0, 0, 0, 0], buttons };
  return { handedness, gamepad };
}

beforeEach(() => {
  vi.useFakeTimers();
  for (const act of Object.values(acted)) act.mockReset();
  const page = testSession();
  state = page.state;
  state.hello.value = hello({ viewer: 1 });
  state.room.value = room({ operator: 1 });
  state.link.value = { is: "connected" };
  input = new InputState({ changed: () => {}, deflected: () => {}, movesSideways: () => false });
  input.enable();
  acted.letGo.mockImplementation(() => input.releaseAll());
  const actions = Object.assign(Object.create(page.actions), acted, {
    press: input.press.bind(input),
    deflect: input.deflect.bind(input),
    release: input.release.bind(input),
  });
  session = Object.assign(new EventTarget(), {
    visibilityState: "visible" as XRVisibilityState,
    inputSources: [touch("left"), touch("right")],
  });
  ending = new AbortController();
  seen = listenHands({ state, actions }, session, ending.signal).seen;
  frames();
});
afterEach(() => ending.abort());

/** Draws for a while, as a headset does 72 times a second. */
function frames(ms = 100): void {
  for (let at = 0; at < ms; at += 10) {
    seen.drawn();
    vi.advanceTimersByTime(10);
  }
}

function press(hand: 0 | 1, at: number, pressed = true): void {
  const buttons = session.inputSources[hand]?.gamepad.buttons;
  if (buttons) buttons[at] = { pressed, value: Number(pressed) };
  frames();
}

function push(hand: 0 | 1, across: number, along: number): void {
  session.inputSources[hand]?.gamepad.axes.splice(2, 2, across, along);
  frames();
}

function drive(): void {
  press(0, SQUEEZE);
  push(0, 0, -1);
}

describe("the robot moves", () => {
  it("by a stick while a grip is squeezed, and not longer", () => {
    drive();
    expect(input.motion).toEqual({ linear: 1, angular: 0 });
    press(0, SQUEEZE, false);
    expect(input.isHolding).toBe(false);
  });

  it("only once the sticks have rested since the squeeze", () => {
    push(1, -1, 0);
    press(0, SQUEEZE);
    expect(input.isHolding).toBe(false);
    push(1, 0, 0);
    push(1, -1, 0);
    expect(input.motion.angular).toBe(1);
  });
});

describe("the robot stops", () => {
  beforeEach(drive);

  it.each(["hidden", "visible-blurred"] as const)("at once when it is %s", (visibility) => {
    session.visibilityState = visibility;
    session.dispatchEvent(new Event("visibilitychange"));
    expect(acted.letGo).toHaveBeenCalledTimes(1);
    frames();
    session.visibilityState = "visible";
    frames();
    expect(input.isHolding).toBe(false);
  });

  it("at once when the session ends", () => {
    session.dispatchEvent(new Event("end"));
    expect(acted.letGo).toHaveBeenCalledTimes(1);
  });

  it("when no frame is drawn any more", () => {
    vi.advanceTimersByTime(160);
    expect(input.isHolding).toBe(false);
  });

  it("when a controller is gone", () => {
    session.inputSources.shift();
    frames();
    expect(input.isHolding).toBe(false);
  });
});

describe("Stop", () => {
  it.each([0, 1] as const)("is on hand %i, squeezed or not, for who watches, too", (hand) => {
    state.room.value = room({ watching: [1] });
    press(hand, STOP);
    expect(acted.stop).toHaveBeenCalledTimes(1);
  });

  it("is released by a trigger that is held", () => {
    state.room.value = { ...room({ operator: 1 }), stop: pressedBy("Cleo") };
    session.dispatchEvent(new Event("selectstart"));
    vi.advanceTimersByTime(700);
    session.dispatchEvent(new Event("selectend"));
    vi.advanceTimersByTime(1000);
    expect(acted.releaseStop).not.toHaveBeenCalled();
    session.dispatchEvent(new Event("selectstart"));
    vi.advanceTimersByTime(900);
    expect(acted.releaseStop).toHaveBeenCalledTimes(1);
  });
});

it("answers a call by a trigger", () => {
  session.dispatchEvent(new Event("selectstart"));
  expect(acted.answerCall).not.toHaveBeenCalled();
  state.serverMs.value = 1000;
  state.room.value = { ...room({ watching: [1] }), call: { viewer: 1, until_server_ms: 5000 } };
  session.dispatchEvent(new Event("selectstart"));
  expect(acted.answerCall).toHaveBeenCalledTimes(1);
});
