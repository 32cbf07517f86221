import { beforeEach, expect, it, vi } from "vitest";
import { type Direction, InputState } from "./inputState";

const STAND = { linear: 0, angular: 0 };
/** The root of a half, as it is sent. */
const DIAGONAL = Number(Math.SQRT1_2.toFixed(3));
const onChange = vi.fn();
const deflected = vi.fn();
let input: InputState;
let isPlanar: boolean;

beforeEach(() => {
  vi.useFakeTimers();
  onChange.mockClear();
  deflected.mockClear();
  isPlanar = false;
  input = new InputState({ changed: onChange, deflected, movesSideways: () => isPlanar });
  input.enable();
});

it.each<[Direction, number, number]>([
  ["forward", 1, 0],
  ["back", -1, 0],
  ["left", 0, 1],
  ["right", 0, -1],
])("%s is linear %d and angular %d", (direction, linear, angular) => {
  input.press("a", direction);
  expect(input.motion).toEqual({ linear, angular });
});

it("makes a curve of two directions, and nothing of opposite ones", () => {
  input.press("a", "forward");
  input.press("b", "left");
  expect(input.motion).toEqual({ linear: 1, angular: 1 });
  input.press("c", "back");
  expect(input.motion).toEqual({ linear: 0, angular: 1 });
});

it("releases only what that holder held", () => {
  input.press("key", "forward");
  input.press("finger", "forward");
  expect(input.release("finger")).toBe(true);
  expect(input.release("finger")).toBe(false);
  expect(input.motion.linear).toBe(1);
  input.release("key");
  expect(input.motion).toEqual(STAND);
});

it("reports each change once, and nothing else", () => {
  input.press("a", "forward");
  input.press("a", "forward");
  input.release("b");
  expect(onChange).toHaveBeenCalledTimes(1);
  input.releaseAll();
  input.releaseAll();
  expect(onChange).toHaveBeenCalledTimes(2);
});

it("counts as holding while anything is held, even without motion", () => {
  input.press("a", "forward");
  input.press("b", "back");
  expect(input.isHolding).toBe(true);
  input.release("a");
  input.press("slider", null);
  input.release("b");
  expect(input.motion).toEqual(STAND);
  expect(input.isHolding).toBe(true);
  input.release("slider");
  expect(input.isHolding).toBe(false);
});

it("counts a slider's change as holding its axis, without motion", () => {
  input.touch("pan", 0.5);
  expect(input.axes).toEqual({ pan: 0.5 });
  expect(input.isHolding).toBe(true);
  expect(input.motion).toEqual(STAND);
});

it("releases an axis 300 ms after its newest change", () => {
  input.touch("pan", 0.5);
  vi.advanceTimersByTime(299);
  input.touch("pan", 0.6);
  vi.advanceTimersByTime(299);
  expect(input.axes).toEqual({ pan: 0.6 });
  expect(onChange).toHaveBeenCalledTimes(1);
  vi.advanceTimersByTime(1);
  expect(input.axes).toEqual({});
  expect(input.isHolding).toBe(false);
  expect(onChange).toHaveBeenCalledTimes(2);
});

it("releases each axis by its own timer, and nothing else", () => {
  input.press("a", "forward");
  input.touch("pan", 0.5);
  vi.advanceTimersByTime(200);
  input.touch("tilt", -1);
  expect(input.axes).toEqual({ pan: 0.5, tilt: -1 });
  vi.advanceTimersByTime(100);
  expect(input.axes).toEqual({ tilt: -1 });
  vi.advanceTimersByTime(200);
  expect(input.axes).toEqual({});
  expect(input.motion.linear).toBe(1);
});

it("starts a new time for an axis touched again after everything was released", () => {
  input.touch("pan", 0.5);
  input.releaseAll();
  expect(input.axes).toEqual({});
  expect(onChange).toHaveBeenCalledTimes(2);
  vi.advanceTimersByTime(200);
  input.touch("pan", 0.6);
  vi.advanceTimersByTime(299);
  expect(input.axes).toEqual({ pan: 0.6 });
});

it("holds nothing while disabled", () => {
  input.press("a", "forward");
  input.touch("pan", 0.5);
  input.disable();
  expect(input.motion).toEqual(STAND);
  input.press("a", "forward");
  input.touch("pan", 0.6);
  expect(input.motion).toEqual(STAND);
  input.enable();
  expect(input.isHolding).toBe(false);
  expect(input.axes).toEqual({});
});

it("needs a new press when a turn begins", () => {
  input.press("a", "forward");
  input.enable();
  expect(input.motion).toEqual(STAND);
  input.press("a", "forward");
  expect(input.motion.linear).toBe(1);
});

it("sums sticks and keys within the limits", () => {
  input.press("stick", { linear: 0.5, angular: -0.25 });
  expect(input.motion).toEqual({ linear: 0.5, angular: -0.25 });
  input.press("key", "forward");
  input.press("pad", { linear: 0, angular: -0.5 });
  expect(input.motion).toEqual({ linear: 1, angular: -0.75 });
  input.press("another", { linear: 0, angular: -1 });
  expect(input.motion).toEqual({ linear: 1, angular: -1 });
});

it.each<[Direction, number]>([
  ["lateral_left", 1],
  ["lateral_right", -1],
])("%s is lateral %d, and nothing on a robot that cannot", (direction, lateral) => {
  input.press("a", direction);
  expect(input.motion).toEqual(STAND);
  isPlanar = true;
  expect(input.motion).toEqual({ ...STAND, lateral });
});

it("is no faster on a diagonal than straight ahead, by keys or sticks, and turns apart", () => {
  isPlanar = true;
  input.press("a", "forward");
  input.press("b", "lateral_right");
  input.press("c", "left");
  expect(input.motion).toEqual({ linear: DIAGONAL, angular: 1, lateral: -DIAGONAL });
  input.releaseAll();
  input.press("stick", { linear: 0.6, angular: 0, lateral: 0.8 });
  expect(input.motion).toEqual({ linear: 0.6, angular: 0, lateral: 0.8 });
  input.press("key", "lateral_left");
  const { linear, lateral = 0 } = input.motion;
  expect(Math.hypot(linear, lateral)).toBeCloseTo(1, 2);
  expect(lateral / linear).toBeCloseTo(1.8 / 0.6, 1);
});

it("reports a stick that is moved only sideways", () => {
  input.press("stick", { ...STAND, lateral: 0 });
  expect(input.deflect("stick", { ...STAND, lateral: 0.5 })).toBe(true);
  expect(deflected).toHaveBeenCalledOnce();
});

it("counts a centred stick as held, without motion", () => {
  input.press("stick", STAND);
  expect(input.isHolding).toBe(true);
  expect(input.motion).toEqual(STAND);
});

it("reports a stick once for each deflection", () => {
  input.press("stick", STAND);
  expect(input.deflect("stick", { linear: 0.3, angular: 0 })).toBe(true);
  expect(input.deflect("stick", { linear: 0.3, angular: 0 })).toBe(true);
  expect(input.deflect("stick", { linear: 0.3, angular: 0.1 })).toBe(true);
  expect(deflected).toHaveBeenCalledTimes(2);
  expect(onChange).toHaveBeenCalledTimes(1);
  expect(input.motion).toEqual({ linear: 0.3, angular: 0.1 });
});

it("deflects only a held stick", () => {
  expect(input.deflect("stick", { linear: 1, angular: 0 })).toBe(false);
  input.press("stick", STAND);
  input.press("key", "left");
  input.releaseAll();
  expect(input.deflect("stick", { linear: 1, angular: 0 })).toBe(false);
  input.press("key", "left");
  expect(input.deflect("key", { linear: 1, angular: 0 })).toBe(false);
  expect(input.motion).toEqual({ linear: 0, angular: 1 });
});

it("knows the holders, and whether anything can be held", () => {
  input.press("a", null);
  expect([input.isHeldBy("a"), input.isHeldBy("b")]).toEqual([true, false]);
  expect(input.isEnabled).toBe(true);
  input.disable();
  expect([input.isHeldBy("a"), input.isEnabled]).toEqual([false, false]);
});

it("rounds the motion to thousandths, never to -0", () => {
  input.press("stick", { linear: 0.123456789, angular: -0.0001 });
  expect(input.motion).toEqual({ linear: 0.123, angular: 0 });
});
