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
  input = new InputState({
    changed: () => {},
    deflected: () => {},
    movesSideways: () => false,
  });
  input.enable();
  ways = new Ways({ input, way: () => way, stepMs: () => 400 });
});

it("drives while held, with the way hold", () => {
  ways.press("a", "forward");
  vi.advanceTimersByTime(10_000);
  expect(input.motion.linear).toBe(1);
  expect(ways.isStepping).toBe(false);
  expect(ways.release("a")).toBe(true);
  expect(input.isHolding).toBe(false);
});

it.each(["step", "scan"] as const)("makes one short slow move per press, with %s", (one) => {
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

it("restarts a step by another press, and turns it by another direction", () => {
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

it("does not end a new step when an old one's time is over", () => {
  way = "step";
  ways.press("a", "forward");
  vi.advanceTimersByTime(200);
  input.releaseAll();
  ways.press("a", "back");
  vi.advanceTimersByTime(399);
  expect(input.motion.linear).toBe(-1);
});

it("moves for exactly two seconds per click", () => {
  way = "click";
  ways.press("a", "left");
  ways.release("a");
  expect(ways.isStepping).toBe(false);
  vi.advanceTimersByTime(1999);
  expect(input.motion.angular).toBe(1);
  vi.advanceTimersByTime(1);
  expect(input.isHolding).toBe(false);
});

it("restarts the time with each click", () => {
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

it("does not interrupt a step", () => {
  way = "step";
  ways.press("a", "forward");
  ways.interrupt();
  expect(input.motion.linear).toBe(1);
});

it("holds keys even if buttons are clicked", () => {
  way = "click";
  ways.pressKey("key", "forward");
  vi.advanceTimersByTime(5000);
  expect(input.motion.linear).toBe(1);
  ways.release("key");
  expect(input.isHolding).toBe(false);
});

it("holds a stick, whatever the way", () => {
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

it("knows whether anything depended on a cancelled touch", () => {
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
