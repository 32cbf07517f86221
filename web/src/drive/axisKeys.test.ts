import { beforeEach, expect, it, vi } from "vitest";
import { AxisKeys, keyedAxes } from "./axisKeys";
import { InputState } from "./inputState";

let positions: Record<string, number>;
let input: InputState;
let axisKeys: AxisKeys;

beforeEach(() => {
  vi.useFakeTimers();
  positions = {};
  input = new InputState({
    changed: () => {},
    deflected: () => {},
    movesSideways: () => false,
  });
  input.enable();
  axisKeys = new AxisKeys({
    input,
    position: (axis) => positions[axis] ?? 0,
    setAxis(axis, position) {
      positions[axis] = position;
      input.touch(axis, position);
    },
  });
});

it("moves an axis at once and steadily while its key is held, as a dead-man switch", () => {
  axisKeys.begin("key", "pan", 1);
  expect(positions.pan).toBeCloseTo(0.05, 10);
  vi.advanceTimersByTime(450);
  expect(positions.pan).toBeCloseTo(0.5, 10);
  expect(input.isHolding).toBe(true);
  input.release("key");
  vi.advanceTimersByTime(1000);
  expect(positions.pan).toBeCloseTo(0.5, 10);
  expect(input.isHolding).toBe(false);
});

it("stops at the ends", () => {
  axisKeys.begin("a", "pan", 1);
  axisKeys.begin("b", "tilt", -1);
  vi.advanceTimersByTime(5000);
  expect(positions).toEqual({ pan: 1, tilt: -1 });
});

it("ends however the key is released", () => {
  axisKeys.begin("key", "pan", 1);
  input.releaseAll();
  vi.advanceTimersByTime(1000);
  expect(positions.pan).toBeCloseTo(0.05, 10);
  expect(vi.getTimerCount()).toBe(0);
});

it("moves nothing while nothing can be held", () => {
  input.disable();
  axisKeys.begin("key", "pan", 1);
  vi.advanceTimersByTime(1000);
  expect(positions).toEqual({});
});

it.each([
  [["pan"], ["pan", undefined]],
  [
    ["arm", "tilt", "pan"],
    ["pan", "tilt"],
  ],
  [
    ["lift", "arm"],
    ["lift", "arm"],
  ],
  [
    ["grip", "pan_head"],
    ["pan_head", "grip"],
  ],
  [["tilt"], [undefined, "tilt"]],
  [[], [undefined, undefined]],
])("of %j the keys move %j", (axes, keyed) => {
  expect(keyedAxes(axes)).toEqual(keyed);
});
