/** What each key action does while driving; which key has which action: `keyMap.ts`. */

import { type AxisKeys, keyedAxes } from "./axisKeys";
import type { KeyAction } from "./keyMap";
import type { Scanner } from "./scanner";
import type { Way, Ways } from "./ways";

export interface KeyActionsOptions {
  ways: Ways;
  way: () => Way;
  scanner: Scanner;
  axisKeys: AxisKeys;
  /** The robot's axes. */
  axes: () => readonly string[];
  recentre: () => void;
  stop: () => void;
  toggleSpeed: () => void;
}

const AXES: Partial<Record<KeyAction, [at: number, sign: 1 | -1]>> = {
  axis1_plus: [0, 1],
  axis1_minus: [0, -1],
  axis2_plus: [1, 1],
  axis2_minus: [1, -1],
};

/** Actions handled elsewhere, because watching and speaking do not need driving. */
const ELSEWHERE: readonly KeyAction[] = ["talk", "cameras", "mute"];

export class KeyActions {
  constructor(private readonly options: KeyActionsOptions) {}

  isFor(action: KeyAction): boolean {
    const { way, axes } = this.options;
    const [at] = AXES[action] ?? [];
    if (at !== undefined) return keyedAxes(axes())[at] !== undefined;
    if (action === "scan_select" || action === "scan_next") return way() === "scan";
    return !ELSEWHERE.includes(action);
  }

  press(holder: string, action: KeyAction): void {
    const { ways, scanner, axisKeys, axes, recentre, stop, toggleSpeed } = this.options;
    switch (action) {
      case "forward":
      case "back":
      case "left":
      case "right":
      case "lateral_left":
      case "lateral_right":
        ways.pressKey(holder, action);
        break;
      case "stop":
        stop();
        break;
      case "speed":
        toggleSpeed();
        break;
      case "recentre":
        recentre();
        break;
      case "scan_select":
        scanner.select();
        break;
      case "scan_next":
        scanner.next();
        break;
      default: {
        const [at, sign] = AXES[action] ?? [];
        const axis = at === undefined ? undefined : keyedAxes(axes())[at];
        if (axis !== undefined && sign !== undefined) axisKeys.begin(holder, axis, sign);
      }
    }
  }
}
