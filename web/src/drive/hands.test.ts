import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { type Direction, Hands } from "./hands";

const STAND = { linear: 0, angular: 0 };
const onChange = vi.fn();
let hands: Hands;

beforeEach(() => {
  vi.useFakeTimers();
  onChange.mockClear();
  hands = new Hands(onChange);
  hands.enable();
});

afterEach(() => vi.useRealTimers());

it.each<[Direction, number, number]>([
  ["forward", 1, 0],
  ["back", -1, 0],
  ["left", 0, 1],
  ["right", 0, -1],
])("%s is linear %d and angular %d", (direction, linear, angular) => {
  hands.press("a", direction);
  expect(hands.motion).toEqual({ linear, angular });
});

it("makes a curve of two, and nothing of opposites", () => {
  hands.press("a", "forward");
  hands.press("b", "left");
  expect(hands.motion).toEqual({ linear: 1, angular: 1 });
  hands.press("c", "back");
  expect(hands.motion).toEqual({ linear: 0, angular: 1 });
});

it("releases only what that holder held", () => {
  hands.press("key", "forward");
  hands.press("finger", "forward");
  expect(hands.release("finger")).toBe(true);
  expect(hands.release("finger")).toBe(false);
  expect(hands.motion.linear).toBe(1);
  hands.release("key");
  expect(hands.motion).toEqual(STAND);
});

it("tells of each change once, and of nothing else", () => {
  hands.press("a", "forward");
  hands.press("a", "forward");
  hands.release("b");
  expect(onChange).toHaveBeenCalledTimes(1);
  hands.releaseAll();
  hands.releaseAll();
  expect(onChange).toHaveBeenCalledTimes(2);
});

it("holds as long as anything is held, though it makes no motion", () => {
  hands.press("a", "forward");
  hands.press("b", "back");
  expect(hands.isHolding).toBe(true);
  hands.release("a");
  hands.press("slider", null);
  hands.release("b");
  expect(hands.motion).toEqual(STAND);
  expect(hands.isHolding).toBe(true);
  hands.release("slider");
  expect(hands.isHolding).toBe(false);
});

it("takes a change of a slider for a hand on its axis, which is no motion", () => {
  hands.touch("pan", 0.5);
  expect(hands.axes).toEqual({ pan: 0.5 });
  expect(hands.isHolding).toBe(true);
  expect(hands.motion).toEqual(STAND);
});

it("lets go of an axis by itself, 300 ms after its newest change", () => {
  hands.touch("pan", 0.5);
  vi.advanceTimersByTime(299);
  hands.touch("pan", 0.6);
  vi.advanceTimersByTime(299);
  expect(hands.axes).toEqual({ pan: 0.6 });
  expect(onChange).toHaveBeenCalledTimes(1);
  vi.advanceTimersByTime(1);
  expect(hands.axes).toEqual({});
  expect(hands.isHolding).toBe(false);
  expect(onChange).toHaveBeenCalledTimes(2);
});

it("lets each axis go by itself, and nothing else with it", () => {
  hands.press("a", "forward");
  hands.touch("pan", 0.5);
  vi.advanceTimersByTime(200);
  hands.touch("tilt", -1);
  expect(hands.axes).toEqual({ pan: 0.5, tilt: -1 });
  vi.advanceTimersByTime(100);
  expect(hands.axes).toEqual({ tilt: -1 });
  vi.advanceTimersByTime(200);
  expect(hands.axes).toEqual({});
  expect(hands.motion.linear).toBe(1);
});

it("leaves a new hand on an axis its own time after all was released", () => {
  hands.touch("pan", 0.5);
  hands.releaseAll();
  expect(hands.axes).toEqual({});
  expect(onChange).toHaveBeenCalledTimes(2);
  vi.advanceTimersByTime(200);
  hands.touch("pan", 0.6);
  vi.advanceTimersByTime(299);
  expect(hands.axes).toEqual({ pan: 0.6 });
});

it("holds nothing while disabled", () => {
  hands.press("a", "forward");
  hands.touch("pan", 0.5);
  hands.disable();
  expect(hands.motion).toEqual(STAND);
  hands.press("a", "forward");
  hands.touch("pan", 0.6);
  expect(hands.motion).toEqual(STAND);
  hands.enable();
  expect(hands.isHolding).toBe(false);
  expect(hands.axes).toEqual({});
});

it("asks for a new press when a turn begins", () => {
  hands.press("a", "forward");
  hands.enable();
  expect(hands.motion).toEqual(STAND);
  hands.press("a", "forward");
  expect(hands.motion.linear).toBe(1);
});
