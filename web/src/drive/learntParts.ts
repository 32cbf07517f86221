/** What a user has taught this page about one gamepad: which of its parts does what. Pure. */

import type { PadPart } from "./padReading";

/** What an axis can do; it is taught by a push ahead or to the left. */
export const AXIS_USES = ["ahead", "turn", "sideways"] as const;
export type AxisUse = (typeof AXIS_USES)[number];

/** A button, or the end to which an axis was pushed: a hat reports its directions as one axis. */
export interface LearntPart extends PadPart {
  to: number;
}

/** By use: an `AxisUse`, a direction, "stop", "speed", or a control by `controlUse`. */
export type Learnt = Readonly<Record<string, LearntPart>>;

export const controlUse = (name: string) => `control ${name}`;

/** How many gamepads are kept, newest last. */
export const MOST_PADS = 8;
const MOST_USES = 32;
/** W3C Gamepad sets no limit; no device has as many. */
export const MOST_PARTS = 64;
/** A hat's directions are at -1, -5/7, …, 1, and its rest beyond: half of a step between them. */
const HAT = 1 / 7;
/** Beyond what any axis or hat reports. */
const FAR = 4;

/** Whether this part is pressed; an axis is only where it was taught. */
export function isPressed(
  { axes, buttons }: Pick<Gamepad, "axes"> & { buttons: readonly { pressed: boolean }[] },
  { kind, at, to }: LearntPart,
): boolean {
  if (kind === "button") return buttons[at]?.pressed === true;
  return Math.abs((axes[at] ?? Number.NaN) - to) < HAT;
}

/** Returns what was stored, by the gamepad's name, as far as it is valid. */
export function loadLearnt(kept: unknown): Readonly<Record<string, Learnt>> {
  const pads = entries(kept).map(([id, uses]) => {
    const parts = entries(uses).filter(([, part]) => isPart(part));
    return [id, Object.fromEntries(parts.slice(0, MOST_USES))];
  });
  return Object.fromEntries(pads.slice(-MOST_PADS));
}

const entries = (kept: unknown) =>
  Object.entries(typeof kept === "object" && kept !== null ? kept : {});

function isPart(part: unknown): boolean {
  const { kind, at, to } = Object(part) as Partial<LearntPart>;
  const isPlace = Number.isInteger(at) && Number(at) >= 0 && Number(at) < MOST_PARTS;
  const isEnd = typeof to === "number" && Math.abs(to) <= FAR;
  return isPlace && isEnd && (kind === "button" || kind === "axis");
}
