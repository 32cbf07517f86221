// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { type FakePad, pad, plugIn, push, readings, takeAwayGamepads } from "../testing/gamepads";
import { numbers } from "../testing/random";
import { GamepadInput } from "./gamepad";
import { NO_PADS, type PadState } from "./gamepads";
import { InputState } from "./inputState";
import type { PadSettings } from "./padReading";
import { FROZEN_MS } from "./padRest";
import { Ways } from "./ways";

const DEAD_ZONE = 0.15;
const tell = vi.fn();

let input: InputState;
let state: PadState;
let mine: FakePad;
let settings: PadSettings;
let aborting: AbortController;
let gamepad: GamepadInput;

beforeEach(() => {
  vi.useFakeTimers();
  vi.spyOn(document, "hasFocus").mockReturnValue(true);
  tell.mockClear();
  settings = {
    turn: "left",
    planarTurn: "right",
    triggers: true,
    deadZone: DEAD_ZONE,
    curve: 1,
    rests: {},
    learnt: {},
  };
});

afterEach(() => {
  aborting.abort();
  readings(2);
  takeAwayGamepads();
});

/** Chooses this pad, by default of an unknown layout, in a turn of this page. */
function chooses(axes: number[], more: Partial<FakePad> = {}): void {
  input = new InputState({
    changed: () => {},
    deflected: () => {},
    movesSideways: () => false,
  });
  input.enable();
  state = NO_PADS;
  aborting = new AbortController();
  gamepad = new GamepadInput(window, {
    input,
    ways: new Ways({ input, way: () => "hold", stepMs: () => 400 }),
    controls: () => [],
    operating: { press: vi.fn(), release: vi.fn(), toggle: vi.fn() },
    settings: () => settings,
    movesSideways: () => false,
    isDriving: () => true,
    stop: () => {},
    toggleSpeed: () => {},
    changed(now) {
      state = now;
    },
    tell,
  });
  mine = pad({ mapping: "", axes, ...more });
  gamepad.listen(aborting.signal);
  plugIn([mine]);
  gamepad.use(0);
  vi.advanceTimersByTime(50);
}

/** Holds an axis at this value for this long. */
function says(at: number, value: number, ms = 50): void {
  mine.axes[at] = value;
  vi.advanceTimersByTime(ms);
}

/** Stores the axes' current positions as their rests, as the page does. */
function rests(): void {
  const told = gamepad.restNow();
  expect(told).not.toBeNull();
  settings = { ...settings, rests: { [mine.id]: told ?? [] } };
}

const axis = (at: number) => ({ kind: "axis", at });

it("moves nothing by an axis that was never seen at its rest", () => {
  const between = numbers(34);
  const one = <T>(of: readonly T[]) => of[Math.floor(between(0, of.length))] as T;
  let moved = 0;
  for (let run = 0; run < 80; run++) {
    const own = [one([0, 0, -1, 0.3]), one([0, 0, -1, 0.3]), 0];
    settings = { ...settings, rests: { Xbox: own } };
    chooses([0, 0]);
    const seen = [0, 1].map(() => ({
      hasSpoken: false,
      wasSeen: false,
      wasAway: false,
      isProven: false,
    }));
    let [stoodMs, hasStood] = [50, false];
    for (let step = 0; step < 30; step++) {
      const ms = one([8, 16, 100, 300, 600]);
      // Most of the time one axis moves while another stays still.
      const at = one([0, 1]);
      mine.axes[at] = one([0, own[at] ?? 0, own[at] ?? 0, 0.004, 0.3, -0.6, -1, 1]);
      const isAway = (at: number) => Math.abs((mine.axes[at] ?? 0) - (own[at] ?? 0)) > DEAD_ZONE;
      const isAtRest = !isAway(0) && !isAway(1);
      stoodMs = isAtRest ? stoodMs + ms : 0;
      hasStood ||= stoodMs >= 500;
      seen.forEach((of, at) => {
        of.hasSpoken ||= mine.axes[at] !== 0;
        of.wasSeen ||= of.hasSpoken && !isAway(at);
        of.wasAway ||= hasStood && isAway(at);
        of.isProven ||= of.wasAway && stoodMs >= 500;
      });
      vi.advanceTimersByTime(ms);
      if (!input.isHolding) continue;
      moved += 1;
      seen.forEach((of, at) => {
        if (isAway(at)) expect(of.wasSeen).toBe(true);
        if (own[at] !== 0) expect(of.isProven).toBe(true);
      });
    }
    aborting.abort();
  }
  expect(moved).toBeGreaterThan(50);
});

describe("an axis that has only reported 0", () => {
  it("moves nothing by its first jump, and is named if it stays there", () => {
    chooses([0, 0]);
    says(1, 0, 600);
    expect(state.isReady).toBe(true);
    says(1, -1, 600);
    expect(input.isHolding).toBe(false);
    expect(state).toMatchObject({ isReady: false, held: [axis(1)] });
  });

  it("drives by its second push if it came back in between", () => {
    chooses([0, 0]);
    says(1, 0, 600);
    says(1, -0.8);
    says(1, 0, 600);
    says(1, -0.8);
    expect(input.motion.linear).toBeGreaterThan(0);
  });

  it("drives at once if it starts within the dead zone, or with a standard layout", () => {
    chooses([0, 0]);
    says(1, 0, 600);
    says(1, -0.05);
    says(1, -0.8);
    expect(input.motion.linear).toBeGreaterThan(0);
    aborting.abort();
    chooses([0, 0], { mapping: "standard" });
    says(1, -0.8);
    expect(input.motion.linear).toBeGreaterThan(0);
  });
});

it("is not ready while an axis that rests at an end crosses its middle", () => {
  chooses([0, -1]);
  for (const value of [-0.5, 0, 0.5, 1, 0.5, 0, -0.5, -1]) says(1, value, 60);
  expect(input.isHolding).toBe(false);
  expect(state.held).toEqual([axis(1)]);
});

describe("a stored rest", () => {
  it("is taken from the axes that hold, once they were still for a second", () => {
    chooses([0.02, -0.6]);
    vi.advanceTimersByTime(900);
    expect(gamepad.restNow()).toBeNull();
    vi.advanceTimersByTime(100);
    expect(gamepad.restNow()).toEqual([0, -0.6, 0]);
    says(1, -0.9, 500);
    expect(gamepad.restNow()).toBeNull();
    says(1, -0.94, 600);
    expect(gamepad.restNow()).toEqual([0, -0.94, 0]);
  });

  it("drives once the axis was there, moved away and came back; in the next turn at once", () => {
    chooses([0, -1], { id: "Pedals" });
    says(1, -1, 1100);
    rests();
    says(1, -1, 600);
    expect(state).toMatchObject({ isReady: false, held: [], unmoved: [axis(1)] });
    says(1, 0.5);
    expect(state).toMatchObject({ held: [axis(1)], unmoved: [] });
    expect(input.isHolding).toBe(false);
    says(1, -1, 600);
    expect(state.isReady).toBe(true);
    says(1, 0);
    expect(input.motion.linear).toBeCloseTo(-(0.5 - DEAD_ZONE) / (1 - DEAD_ZONE), 2);
    says(1, -1);
    expect(input.isHolding).toBe(false);
    input.enable();
    says(1, -1, 600);
    says(1, 0);
    expect(input.isHolding).toBe(true);
  });

  it("is not taken from a stick that was held meanwhile", () => {
    chooses([0, 0.004]);
    says(1, -0.6, 1100);
    rests();
    says(1, -0.6, 2000);
    says(1, 0.004, 2000);
    expect(input.isHolding).toBe(false);
    expect(state).toMatchObject({ isReady: false, held: [axis(1)] });
    for (const value of [-0.3, -0.6, -0.9, -0.6, 0.004]) says(1, value);
    expect(input.isHolding).toBe(false);
    says(1, 0.004, 1100);
    rests();
    says(1, 0.004, 600);
    says(1, -0.6);
    says(1, 0.004, 600);
    says(1, -0.6);
    expect(input.motion.linear).toBeGreaterThan(0);
  });

  it("is unknown for a pad that is not read, or for none", () => {
    chooses([0, -1]);
    says(1, -1, 1100);
    vi.mocked(document.hasFocus).mockReturnValue(false);
    vi.advanceTimersByTime(1000);
    expect(gamepad.restNow()).toBeNull();
    gamepad.use(null);
    expect(gamepad.restNow()).toBeNull();
  });
});

it("moves nothing when its dead zone is made smaller", () => {
  settings = { ...settings, deadZone: 0.3 };
  chooses([0, 0.2]);
  says(1, 0.2, 600);
  expect(state.isReady).toBe(true);
  settings = { ...settings, deadZone: 0.1 };
  vi.advanceTimersByTime(1000);
  expect(input.isHolding).toBe(false);
  expect(state.held).toEqual([axis(1)]);
});

describe("real cases", () => {
  it("a pad whose tool has closed, or that is gone but listed, releases after 10 s", () => {
    chooses([0, 0], { mapping: "standard" });
    says(1, -0.637, FROZEN_MS - 100);
    expect(input.isHolding).toBe(true);
    vi.advanceTimersByTime(200);
    expect(input.isHolding).toBe(false);
    vi.advanceTimersByTime(1000);
    expect(tell.mock.calls.filter(([news]) => news === "frozen")).toHaveLength(1);
    says(1, 0);
    says(1, -0.637);
    expect(input.isHolding).toBe(true);
  });

  it("a held stick continues while anything on its pad changes", () => {
    chooses([0, 0], { mapping: "standard" });
    says(1, -1, 9000);
    says(3, 0.004, 9000);
    push(mine, 7, 0.01);
    says(1, -1, 9000);
    expect(input.motion.linear).toBe(1);
  });

  it("a keyboard listed as a pad moves nothing, whatever its axes report", () => {
    for (const axes of [[], [-1, -1], [0, 1, 0, 1], [Number.NaN, 1]]) {
      chooses(axes, { id: "Wired Keyboard 600", buttons: [] });
      vi.advanceTimersByTime(2000);
      expect(input.isHolding).toBe(false);
      expect(state.found).toMatchObject([{ layout: "bare" }]);
      aborting.abort();
    }
  });

  it("a drifting stick is named, and drives relative to its stored rest", () => {
    chooses([0, 0.22, 0, 0], { mapping: "standard" });
    says(1, 0.22, 1100);
    expect(state.held).toEqual([axis(1)]);
    rests();
    says(1, 0.22, 600);
    says(1, -1);
    says(1, 0.25, 600);
    says(1, 0.2);
    expect(input.isHolding).toBe(false);
    says(1, -1);
    expect(input.motion.linear).toBe(1);
  });

  it("a right stick that is off-centre until tapped turns nothing until then", () => {
    settings = { ...settings, turn: "right" };
    chooses([0, 0, 0.9, -0.9], { mapping: "standard" });
    vi.advanceTimersByTime(2000);
    expect(input.isHolding).toBe(false);
    expect(state.held).toEqual([axis(2)]);
    says(2, 0);
    says(2, 0.5);
    expect(input.motion.angular).toBeLessThan(0);
  });
});
