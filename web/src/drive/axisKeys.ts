/** Which two axes have keys, and how fast a key moves one; which keys: `keyMap.ts`. */

import type { InputState } from "./inputState";

/** From one end to the other in two seconds. */
const SHARE_PER_S = 1;
const EVERY_MS = 50;

export interface AxisKeysOptions {
  input: InputState;
  position: (axis: string) => number;
  setAxis: (axis: string, position: number) => void;
}

/** The two axes that have keys: the camera's by their usual names, else the first ones. Pure. */
export function keyedAxes(axes: readonly string[]): (string | undefined)[] {
  const pan = axes.find((axis) => axis.startsWith("pan"));
  const tilt = axes.find((axis) => axis.startsWith("tilt"));
  const others = axes.filter((axis) => axis !== pan && axis !== tilt);
  const first = pan ?? others.shift();
  return [first, tilt ?? others.shift()];
}

/** Moves an axis at a steady rate while its holder holds it. */
export class AxisKeys {
  constructor(private readonly options: AxisKeysOptions) {}

  /** Starts moving, with the first step at once: a short press makes a small move. */
  begin(holder: string, axis: string, sign: 1 | -1): void {
    const { input, position, setAxis } = this.options;
    input.press(holder, null);
    const move = () => {
      if (!input.isHeldBy(holder)) return false;
      const moved = position(axis) + (sign * SHARE_PER_S * EVERY_MS) / 1000;
      setAxis(axis, Math.max(-1, Math.min(1, moved)));
      return true;
    };
    if (!move()) return;
    // The repetition ends as soon as anything has released the holder.
    const timer = setInterval(() => {
      if (!move()) clearInterval(timer);
    }, EVERY_MS);
  }
}
