/** What the directions are called. */

import type { Direction } from "../drive/inputState";
import type { Code } from "../words/words";

const NAMES: Record<Direction, Code> = {
  forward: "drive.forward",
  back: "drive.back",
  left: "drive.left",
  right: "drive.right",
  lateral_left: "drive.lateral_left",
  lateral_right: "drive.lateral_right",
};
const PLANAR = { ...NAMES, left: "drive.turn_left", right: "drive.turn_right" } as const;

/** A robot that moves sideways can go left without turning, so there turning is named. */
export function directionNames(movesSideways: boolean): Readonly<Record<Direction, Code>> {
  return movesSideways ? PLANAR : NAMES;
}
