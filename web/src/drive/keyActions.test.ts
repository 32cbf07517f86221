import { beforeEach, expect, it } from "vitest";
import type { AxisKeys } from "./axisKeys";
import { KeyActions } from "./keyActions";
import { KEY_ACTIONS, type KeyAction } from "./keyMap";
import type { Scanner } from "./scanner";
import type { Way, Ways } from "./ways";

let way: Way;
let axes: string[];
let done: string[];
let keyActions: KeyActions;

beforeEach(() => {
  way = "hold";
  axes = ["pan", "tilt"];
  done = [];
  const note =
    (what: string) =>
    (...values: unknown[]) =>
      void done.push([what, ...values].join(" "));
  keyActions = new KeyActions({
    ways: { pressKey: note("press") } as Partial<Ways> as Ways,
    way: () => way,
    scanner: { select: note("select"), next: note("next") } as Partial<Scanner> as Scanner,
    axisKeys: { begin: note("axis") } as Partial<AxisKeys> as AxisKeys,
    axes: () => axes,
    recentre: note("recentre"),
    stop: note("stop"),
    toggleSpeed: note("speed"),
  });
});

it.each<[KeyAction, string]>([
  ["forward", "press key forward"],
  ["back", "press key back"],
  ["left", "press key left"],
  ["right", "press key right"],
  ["lateral_left", "press key lateral_left"],
  ["lateral_right", "press key lateral_right"],
  ["stop", "stop"],
  ["speed", "speed"],
  ["recentre", "recentre"],
  ["axis1_plus", "axis key pan 1"],
  ["axis1_minus", "axis key pan -1"],
  ["axis2_plus", "axis key tilt 1"],
  ["axis2_minus", "axis key tilt -1"],
  ["scan_select", "select"],
  ["scan_next", "next"],
])("%s does %s", (action, called) => {
  keyActions.press("key", action);
  expect(done).toEqual([called]);
});

it("moves no axis that the robot lacks, and ignores actions handled elsewhere", () => {
  axes = ["pan"];
  for (const action of ["axis2_plus", "talk", "cameras", "mute"] as const)
    keyActions.press("key", action);
  expect(done).toEqual([]);
});

it("handles everything that drives, existing axes, and switches while scanning", () => {
  const others = () => KEY_ACTIONS.filter((action) => !keyActions.isFor(action));
  expect(others()).toEqual(["talk", "cameras", "mute", "scan_select", "scan_next"]);
  way = "scan";
  axes = ["pan"];
  expect(others()).toEqual(["axis2_plus", "axis2_minus", "talk", "cameras", "mute"]);
});
