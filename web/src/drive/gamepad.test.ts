// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { ControlInfo } from "../messages";
import { type FakePad, pad, plugIn, push, readings, takeAwayGamepads } from "../testing/gamepads";
import { control } from "../testing/messages";
import { GamepadInput } from "./gamepad";
import { NO_PADS, type PadState } from "./gamepads";
import { InputState } from "./inputState";
import type { PadSettings } from "./padReading";
import { Ways } from "./ways";

const STAND = { linear: 0, angular: 0 };
const stop = vi.fn();
const toggleSpeed = vi.fn();
const tell = vi.fn();
const operating = { press: vi.fn(), release: vi.fn(() => true), toggle: vi.fn() };

let input: InputState;
let state: PadState;
let mine: FakePad;
let driving: boolean;
let focused: boolean;
let aborting: AbortController;
let gamepad: GamepadInput;
let settings: PadSettings;
let isPlanar: boolean;
let controls: ControlInfo[];

beforeEach(() => {
  vi.useFakeTimers();
  for (const action of [stop, toggleSpeed, tell, ...Object.values(operating)]) action.mockClear();
  input = new InputState({
    changed: () => {},
    deflected: () => {},
    movesSideways: () => isPlanar,
  });
  input.enable();
  state = NO_PADS;
  mine = pad();
  settings = {
    turn: "left",
    planarTurn: "right",
    triggers: true,
    deadZone: 0.2,
    curve: 1,
    rests: {},
    learnt: {},
  };
  controls = [];
  driving = true;
  isPlanar = false;
  focused = true;
  vi.spyOn(document, "hasFocus").mockImplementation(() => focused);
  aborting = new AbortController();
  gamepad = new GamepadInput(window, {
    input,
    ways: new Ways({ input, way: () => "hold", stepMs: () => 400 }),
    controls: () => controls,
    operating,
    settings: () => settings,
    movesSideways: () => isPlanar,
    isDriving: () => driving,
    stop,
    toggleSpeed,
    changed(now) {
      state = now;
    },
    tell,
  });
});

afterEach(() => {
  aborting.abort();
  readings(2);
  expect(vi.getTimerCount()).toBe(0);
  takeAwayGamepads();
});

function listens(): void {
  gamepad.listen(aborting.signal);
}

/** A chosen pad that has been released once. */
function drives(): void {
  listens();
  plugIn([mine]);
  gamepad.use(0);
  readings(2);
  expect(state).toMatchObject({ chosen: 0, isReady: true });
}

describe("a robot that moves sideways", () => {
  beforeEach(() => {
    isPlanar = true;
  });

  it("moves by either stick alone, and stops when that is released", () => {
    drives();
    mine.axes[0] = -1;
    readings(1);
    expect(input.motion).toEqual({ linear: 0, angular: 0, lateral: 1 });
    mine.axes[0] = 0;
    readings(1);
    expect(input.isHolding).toBe(false);
    mine.axes[2] = 1;
    readings(1);
    expect(input.motion).toEqual({ linear: 0, angular: -1, lateral: 0 });
  });

  it("moves nothing until both sticks have been released once", () => {
    mine.axes[2] = 1;
    listens();
    plugIn([mine]);
    gamepad.use(0);
    readings(2);
    expect(state).toMatchObject({ isReady: false, held: [{ kind: "axis", at: 2 }] });
    mine.axes[2] = 0;
    readings(2);
    expect(state.isReady).toBe(true);
  });

  it("moves sideways while LB or RB is held", () => {
    drives();
    push(mine, 5);
    readings(1);
    expect(input.motion.lateral).toBe(-1);
    push(mine, 5, 0);
    readings(1);
    expect(input.isHolding).toBe(false);
  });
});

describe("the robot's controls", () => {
  const HORN = "pad-control horn";

  beforeEach(() => {
    controls = [
      control("horn", { pad_button: "X" }),
      control("lamp", { kind: "toggle", pad_button: "Y" }),
    ];
  });

  it("are held as long as their button, or flipped at its press", () => {
    drives();
    push(mine, 2);
    push(mine, 3);
    readings(2);
    expect(operating.press).toHaveBeenCalledExactlyOnceWith(HORN, "horn");
    expect(operating.toggle).toHaveBeenCalledExactlyOnceWith("lamp");
    expect(operating.release).not.toHaveBeenCalledWith(HORN);
    push(mine, 2, 0);
    readings(1);
    expect(operating.release).toHaveBeenCalledWith(HORN);
  });

  it.each([
    ["the pad vanishes", () => plugIn([])],
    ["the page loses the focus", () => (focused = false)],
    ["nobody may drive any more", () => input.disable()],
    [
      "the user may no longer use it",
      () => {
        controls = [];
        push(mine, 2, 0);
      },
    ],
  ])("are let go of when %s", (_, happens) => {
    drives();
    push(mine, 2);
    readings(1);
    happens();
    readings(1);
    expect(operating.release).toHaveBeenCalledWith(HORN);
  });

  it("are not pressed by a button that was held before", () => {
    push(mine, 2);
    listens();
    plugIn([mine]);
    gamepad.use(0);
    readings(3);
    expect(operating.press).not.toHaveBeenCalled();
  });
});

describe("choosing a part by pressing it", () => {
  it("moves and presses nothing, and drives again once all is let go of", () => {
    controls = [control("horn", { pad_button: "X" })];
    drives();
    const found = vi.fn();
    gamepad.learn({ isAxis: false, found });
    mine.axes[1] = -1;
    readings(1);
    expect(input.isHolding).toBe(false);
    push(mine, 2);
    readings(1);
    expect(found).toHaveBeenCalledExactlyOnceWith({ kind: "button", at: 2, to: 1, from: 0 });
    readings(1);
    expect(operating.press).not.toHaveBeenCalled();
    expect([input.isHolding, state.isReady]).toEqual([false, false]);
    mine.axes[1] = 0;
    push(mine, 2, 0);
    readings(2);
    expect(state.isReady).toBe(true);
  });

  it("still stops, and ends with the pad or the wish", () => {
    drives();
    const found = vi.fn();
    gamepad.learn({ isAxis: true, found });
    readings(1);
    focused = false;
    mine.axes[1] = -1;
    readings(1);
    mine.axes[1] = 0;
    readings(1);
    focused = true;
    readings(1);
    push(mine, 1);
    readings(1);
    expect(stop).toHaveBeenCalledOnce();
    push(mine, 1, 0);
    gamepad.learn(null);
    readings(2);
    expect(state.isReady).toBe(true);
    gamepad.learn({ isAxis: true, found });
    gamepad.use(0);
    readings(2);
    expect(state.isReady).toBe(true);
    gamepad.use(null);
    gamepad.learn({ isAxis: true, found });
    readings(2);
    expect(found).not.toHaveBeenCalled();
  });
});

describe("a pad that was not chosen", () => {
  it("moves nothing, and is announced once", () => {
    listens();
    plugIn([mine]);
    mine.axes[1] = -1;
    readings(100);
    expect(input.isHolding).toBe(false);
    expect(state).toEqual({
      found: [{ index: 0, id: "Xbox", layout: "standard" }],
      chosen: null,
      isReady: false,
      held: [],
      unmoved: [],
    });
    expect(tell).toHaveBeenCalledExactlyOnceWith("found");
  });

  it("is found if it was connected before the page opened", () => {
    plugIn([null, { ...mine, index: 1 }]);
    listens();
    expect(state.found).toEqual([{ index: 1, id: "Xbox", layout: "standard" }]);
  });

  it("can be chosen for a while by a new press of its Start", () => {
    listens();
    push(mine, 9);
    plugIn([mine]);
    readings(5);
    expect(state.chosen).toBeNull();
    push(mine, 9, 0);
    readings(2);
    push(mine, 9);
    readings(2);
    expect(state).toMatchObject({ chosen: 0, isReady: false });
    gamepad.use(null);
    push(mine, 9, 0);
    readings(2);
    push(mine, 9);
    readings(2);
    expect(state.chosen).toBeNull();
  });

  it("is read only for a while", () => {
    listens();
    plugIn([mine]);
    vi.advanceTimersByTime(20_100);
    push(mine, 9);
    readings(5);
    expect(state.chosen).toBeNull();
    expect(vi.getTimerCount()).toBe(0);
  });

  it("is not offered if another one drives already", () => {
    drives();
    tell.mockClear();
    plugIn([mine, pad({ index: 1, id: "Other" })]);
    expect(tell).not.toHaveBeenCalled();
    expect(state.found).toHaveLength(2);
    expect(state.chosen).toBe(0);
  });

  it("cannot be chosen if it is missing, or the browser has no Gamepad API", () => {
    listens();
    gamepad.use(3);
    expect(state.chosen).toBeNull();
    plugIn([]);
    gamepad.use(0);
    expect(state.chosen).toBeNull();
  });
});

describe("a pad that was chosen", () => {
  it("drives proportionally, and holds nothing in the dead zone", () => {
    drives();
    mine.axes[1] = -0.6;
    readings(2);
    expect(input.motion.linear).toBeCloseTo(0.5, 10);
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
    mine.axes[1] = -0.1;
    readings(2);
    expect(input.isHolding).toBe(false);
  });

  it("moves nothing until everything on it has been released once", () => {
    listens();
    mine.axes[1] = -1;
    plugIn([mine]);
    gamepad.use(0);
    readings(10);
    expect(input.isHolding).toBe(false);
    mine.axes[1] = 0;
    push(mine, 3);
    readings(2);
    expect(state).toMatchObject({ isReady: false, held: [{ kind: "button", at: 3 }] });
    push(mine, 3, 0);
    readings(2);
    expect(state.isReady).toBe(true);
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
  });

  it.each([
    ["everything was released", () => input.releaseAll()],
    [
      "a turn began",
      () => {
        input.disable();
        input.enable();
      },
    ],
    [
      "it was not this page's turn",
      () => {
        input.disable();
        readings(2);
        input.enable();
      },
    ],
    [
      "the page was not in front",
      () => {
        focused = false;
        readings(2);
        focused = true;
      },
    ],
    [
      "the page was hidden",
      () => {
        const hidden = vi.spyOn(document, "hidden", "get").mockReturnValue(true);
        readings(2);
        hidden.mockReturnValue(false);
      },
    ],
  ])("moves nothing after %s, until it was let go", (_, happen) => {
    drives();
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
    happen();
    readings(10);
    expect(input.isHolding).toBe(false);
    expect(state.isReady).toBe(false);
    mine.axes[1] = 0;
    readings(2);
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
  });

  it("drives although an unused switch stays on, beside a second pad", () => {
    mine = pad({ mapping: "", buttons: pad().buttons.concat(pad().buttons) });
    push(mine, 24);
    listens();
    plugIn([pad({ index: 1, id: "Other", axes: [0, 1, 0, 0] }), mine]);
    expect(tell).toHaveBeenCalledExactlyOnceWith("found");
    mine.axes[1] = -1;
    gamepad.use(0);
    readings(10);
    expect(input.isHolding).toBe(false);
    expect(state.held).toEqual([{ kind: "axis", at: 1 }]);
    mine.axes[1] = 0;
    readings(11);
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
  });

  it("is announced without Start if its Start is not known", () => {
    mine = pad({ mapping: "" });
    listens();
    plugIn([mine]);
    expect(tell).toHaveBeenCalledExactlyOnceWith("found_by_menu");
    vi.advanceTimersByTime(20_100);
  });

  it("drives by its D-pad", () => {
    drives();
    push(mine, 14);
    readings(2);
    expect(input.motion).toEqual({ linear: 0, angular: 1 });
    push(mine, 14, 0);
    readings(2);
    expect(input.isHolding).toBe(false);
  });

  it("stops by B and changes the speed by A, once per press", () => {
    drives();
    push(mine, 1);
    readings(5);
    expect(stop).toHaveBeenCalledOnce();
    push(mine, 0);
    readings(5);
    expect(toggleSpeed).toHaveBeenCalledOnce();
  });

  it("stops by B even before it may drive, but not in somebody else's turn or another window", () => {
    listens();
    mine.axes[1] = -1;
    plugIn([mine]);
    gamepad.use(0);
    push(mine, 1);
    readings(2);
    expect(stop).toHaveBeenCalledOnce();
    for (const undo of [() => (driving = false), () => (focused = false)]) {
      push(mine, 1, 0);
      readings(2);
      undo();
      push(mine, 1);
      readings(2);
      driving = true;
      expect(stop).toHaveBeenCalledOnce();
    }
  });

  it("does not stop by a button pressed before it was chosen", () => {
    listens();
    push(mine, 1);
    plugIn([mine]);
    gamepad.use(0);
    readings(5);
    expect(stop).not.toHaveBeenCalled();
  });

  it("is no longer read once the user has chosen none", () => {
    drives();
    mine.axes[1] = -1;
    readings(2);
    gamepad.use(null);
    expect(input.isHolding).toBe(false);
    readings(5);
    expect(input.isHolding).toBe(false);
  });
});

describe("a lost pad releases everything at once, is announced, and is no longer used", () => {
  const pads: (FakePad | null)[] = [];

  beforeEach(() => {
    pads.splice(0, pads.length, mine);
    listens();
    plugIn(pads);
    gamepad.use(0);
    readings(2);
    mine.axes[1] = -1;
    readings(2);
    expect(input.motion.linear).toBe(1);
    tell.mockClear();
  });

  it.each([
    ["disconnected", () => (mine.connected = false)],
    ["not named any more", () => (pads[0] = null)],
    ["another one in its place", () => (pads[0] = pad({ id: "Other", axes: [0, -1, 0, 0] }))],
  ])("%s", (_, lose) => {
    lose();
    readings(1);
    expect(input.motion).toEqual(STAND);
    expect(input.isHolding).toBe(false);
    expect(state.chosen).toBeNull();
    expect(tell).toHaveBeenCalledExactlyOnceWith("lost");
    readings(10);
    expect(input.isHolding).toBe(false);
  });

  it("on the browser's event, before the next reading", () => {
    pads[0] = null;
    window.dispatchEvent(new Event("gamepaddisconnected"));
    expect(input.isHolding).toBe(false);
    expect(tell).toHaveBeenCalledExactlyOnceWith("lost");
  });

  it("unless another pad was lost", () => {
    window.dispatchEvent(new Event("gamepaddisconnected"));
    expect(input.motion.linear).toBe(1);
  });
});

describe("how often it is read", () => {
  /** Readings a second. */
  function perSecond(): number {
    const read = vi.spyOn(navigator, "getGamepads");
    vi.advanceTimersByTime(1000);
    const count = read.mock.calls.length;
    read.mockRestore();
    return count;
  }

  it("reads a push within 8 ms while this page may drive", () => {
    drives();
    mine.axes[1] = -1;
    vi.advanceTimersByTime(8);
    expect(input.motion.linear).toBe(1);
    mine.axes[1] = 0;
    vi.advanceTimersByTime(8);
    expect(input.isHolding).toBe(false);
  });

  it("reads slowly before that, and never if none is used", () => {
    listens();
    plugIn([mine]);
    expect(perSecond()).toBe(20);
    gamepad.use(0);
    input.disable();
    readings(1);
    expect(perSecond()).toBe(20);
    gamepad.use(null);
    readings(1);
    expect(perSecond()).toBe(0);
  });

  it.each([
    ["a quarter of a second late releases, until all is released", 243, false],
    ["a little late does not", 200, true],
  ])("%s", (_, lateMs, isHolding) => {
    drives();
    mine.axes[1] = -1;
    readings(1);
    // Simulates a browser that delays timers: the next one finds that this much time has passed.
    const { now } = performance;
    vi.spyOn(performance, "now").mockImplementation(() => now.call(performance) + lateMs);
    vi.advanceTimersByTime(8);
    expect(input.isHolding).toBe(isHolding);
    readings(5);
    expect(input.isHolding).toBe(isHolding);
    mine.axes[1] = 0;
    readings(1);
    mine.axes[1] = -1;
    readings(1);
    expect(input.motion.linear).toBe(1);
  });
});
