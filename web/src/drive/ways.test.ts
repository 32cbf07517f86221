import { beforeEach, expect, it, vi } from "vitest";
import { InputState } from "./inputState";
import { type Way, Ways } from "./ways";

const STAND = { linear: 0, angular: 0 };
let way: Way;
let input: InputState;
let ways: Ways;

beforeEach(() => {
  vi.useFakeTimers();
  way = "hold";
  input = new InputState({ changed: () => {}, deflected: () => {} });
  input.enable();
  ways = new Ways({ input, way: () => way, stepMs: () => 400 });
});

it("drives while it is held, where holding is the way", () => {
  ways.press("a", "forward");
  vi.advanceTimersByTime(10_000);
  expect(input.motion.linear).toBe(1);
  expect(ways.isStepping).toBe(false);
  expect(ways.release("a")).toBe(true);
  expect(input.isHolding).toBe(false);
});

it.each(["step", "scan"] as const)("makes one short slow move of a press, by %s", (one) => {
  way = one;
  ways.press("a", "forward");
  expect(ways.isStepping).toBe(true);
  expect(ways.release("a")).toBe(false);
  vi.advanceTimersByTime(399);
  expect(input.motion.linear).toBe(1);
  vi.advanceTimersByTime(1);
  expect(input.isHolding).toBe(false);
  expect(ways.isStepping).toBe(false);
});

it("renews a step by another press, and turns it by one of another direction", () => {
  way = "step";
  ways.press("a", "forward");
  vi.advanceTimersByTime(300);
  ways.pressKey("a", "forward");
  vi.advanceTimersByTime(300);
  expect(input.motion).toEqual({ linear: 1, angular: 0 });
  ways.press("b", "left");
  expect(input.motion).toEqual({ linear: 0, angular: 1 });
  vi.advanceTimersByTime(400);
  expect(input.motion).toEqual(STAND);
});

it("does not let an old step's end end a new one", () => {
  way = "step";
  ways.press("a", "forward");
  vi.advanceTimersByTime(200);
  input.releaseAll();
  ways.press("a", "back");
  vi.advanceTimersByTime(399);
  expect(input.motion.linear).toBe(-1);
});

it("moves for two seconds by a click, and not a moment longer", () => {
  way = "click";
  ways.press("a", "left");
  ways.release("a");
  expect(ways.isStepping).toBe(false);
  vi.advanceTimersByTime(1999);
  expect(input.motion.angular).toBe(1);
  vi.advanceTimersByTime(1);
  expect(input.isHolding).toBe(false);
});

it("goes on from each click anew", () => {
  way = "click";
  ways.press("a", "left");
  vi.advanceTimersByTime(1500);
  ways.press("a", "left");
  vi.advanceTimersByTime(1500);
  expect(input.motion.angular).toBe(1);
});

it.each([
  ["anything else", () => ways.interrupt()],
  ["a stick", () => ways.press("stick", STAND)],
  ["a slider", () => ways.press("slider", null)],
])("ends what a click began by %s", (_, other) => {
  way = "click";
  ways.press("a", "forward");
  other();
  expect(input.motion).toEqual(STAND);
});

it("does not end a step by something else", () => {
  way = "step";
  ways.press("a", "forward");
  ways.interrupt();
  expect(input.motion.linear).toBe(1);
});

it("holds keys, where buttons are clicked", () => {
  way = "click";
  ways.pressKey("key", "forward");
  vi.advanceTimersByTime(5000);
  expect(input.motion.linear).toBe(1);
  ways.release("key");
  expect(input.isHolding).toBe(false);
});

it("holds a stick, whatever becomes of directions", () => {
  way = "step";
  ways.press("stick", { linear: 0.5, angular: 0 });
  vi.advanceTimersByTime(5000);
  expect(input.motion.linear).toBe(0.5);
});

it("steps for a switch", () => {
  way = "scan";
  ways.step("switch", "right");
  expect(input.motion.angular).toBe(-1);
  vi.advanceTimersByTime(400);
  expect(input.isHolding).toBe(false);
});

it("knows whether anything hung on a touch that was cancelled", () => {
  ways.press("finger", "forward");
  expect(ways.cancel("finger")).toBe(true);
  expect(ways.cancel("finger")).toBe(false);
  way = "click";
  ways.press("finger", "forward");
  expect(ways.cancel("another")).toBe(false);
  expect(ways.cancel("finger")).toBe(true);
  input.releaseAll();
  expect(ways.cancel("finger")).toBe(false);
});
