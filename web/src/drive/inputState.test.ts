import { beforeEach, expect, it, vi } from "vitest";
import { type Direction, InputState } from "./inputState";

const STAND = { linear: 0, angular: 0 };
const onChange = vi.fn();
const deflected = vi.fn();
let input: InputState;

beforeEach(() => {
  vi.useFakeTimers();
  onChange.mockClear();
  deflected.mockClear();
  input = new InputState({ changed: onChange, deflected });
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

it("makes a curve of two, and nothing of opposites", () => {
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

it("tells of each change once, and of nothing else", () => {
  input.press("a", "forward");
  input.press("a", "forward");
  input.release("b");
  expect(onChange).toHaveBeenCalledTimes(1);
  input.releaseAll();
  input.releaseAll();
  expect(onChange).toHaveBeenCalledTimes(2);
});

it("holds as long as anything is held, though it makes no motion", () => {
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

it("takes a change of a slider for a hand on its axis, which is no motion", () => {
  input.touch("pan", 0.5);
  expect(input.axes).toEqual({ pan: 0.5 });
  expect(input.isHolding).toBe(true);
  expect(input.motion).toEqual(STAND);
});

it("lets go of an axis by itself, 300 ms after its newest change", () => {
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

it("lets each axis go by itself, and nothing else with it", () => {
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

it("leaves a new hand on an axis its own time after all was released", () => {
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

it("asks for a new press when a turn begins", () => {
  input.press("a", "forward");
  input.enable();
  expect(input.motion).toEqual(STAND);
  input.press("a", "forward");
  expect(input.motion.linear).toBe(1);
});

it("sums what sticks and keys ask for, within the limits", () => {
  input.press("stick", { linear: 0.5, angular: -0.25 });
  expect(input.motion).toEqual({ linear: 0.5, angular: -0.25 });
  input.press("key", "forward");
  input.press("pad", { linear: 0, angular: -0.5 });
  expect(input.motion).toEqual({ linear: 1, angular: -0.75 });
  input.press("another", { linear: 0, angular: -1 });
  expect(input.motion).toEqual({ linear: 1, angular: -1 });
});

it("holds a stick in its middle, which moves nothing", () => {
  input.press("stick", STAND);
  expect(input.isHolding).toBe(true);
  expect(input.motion).toEqual(STAND);
});

it("tells of a stick that moves, once for each way it points", () => {
  input.press("stick", STAND);
  expect(input.deflect("stick", { linear: 0.3, angular: 0 })).toBe(true);
  expect(input.deflect("stick", { linear: 0.3, angular: 0 })).toBe(true);
  expect(input.deflect("stick", { linear: 0.3, angular: 0.1 })).toBe(true);
  expect(deflected).toHaveBeenCalledTimes(2);
  expect(onChange).toHaveBeenCalledTimes(1);
  expect(input.motion).toEqual({ linear: 0.3, angular: 0.1 });
});

it("moves no stick that nobody holds, and nothing by what is no stick", () => {
  expect(input.deflect("stick", { linear: 1, angular: 0 })).toBe(false);
  input.press("stick", STAND);
  input.press("key", "left");
  input.releaseAll();
  expect(input.deflect("stick", { linear: 1, angular: 0 })).toBe(false);
  input.press("key", "left");
  expect(input.deflect("key", { linear: 1, angular: 0 })).toBe(false);
  expect(input.motion).toEqual({ linear: 0, angular: 1 });
});

it("says who holds, and whether anybody can", () => {
  input.press("a", null);
  expect([input.isHeldBy("a"), input.isHeldBy("b")]).toEqual([true, false]);
  expect(input.isEnabled).toBe(true);
  input.disable();
  expect([input.isHeldBy("a"), input.isEnabled]).toEqual([false, false]);
});

it("asks for thousandths, which are short to send, and never for less than nothing", () => {
  input.press("stick", { linear: 0.123456789, angular: -0.0001 });
  expect(input.motion).toEqual({ linear: 0.123, angular: 0 });
});
