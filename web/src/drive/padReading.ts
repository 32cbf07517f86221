/** Reads a gamepad's sticks and buttons; whether they may drive: `gamepad.ts`. Pure. */

import { type Response, shaped, shapedAxis } from "./deflection";
import { DIRECTIONS, type Direction, type Motion } from "./inputState";

export interface PadSettings extends Response {
  /** The stick that turns. */
  turn: "left" | "right";
  /** The stick that turns a robot which also moves sideways; the other one moves it so. */
  planarTurn: "left" | "right";
  /** Whether the right trigger drives ahead and the left one back. */
  triggers: boolean;
  /** Where the axes rest, by the gamepad's name; 0 where nothing is stored. */
  rests: Readonly<Record<string, readonly number[]>>;
}

/** A gamepad's reading at one moment. */
export interface PadReading {
  motion: Motion;
  /** The directions pressed on the D-pad. */
  directions: ReadonlySet<Direction>;
  stop: boolean;
  speed: boolean;
  start: boolean;
  /** What keeps it from being neutral. */
  held: readonly PadPart[];
  /** The axes that count, as the browser reports them, and where they rest. */
  axes: readonly { at: number; value: number; rest: number }[];
}

/** A button or a stick's axis, by its place in the browser's list. */
export interface PadPart {
  kind: "button" | "axis";
  at: number;
}

/** What a gamepad can do here: `unknown` has no known Start button, `bare` also no Stop. */
export type PadLayout = "standard" | "unknown" | "bare";

export type Pad = Pick<Gamepad, "id" | "axes" | "mapping"> & {
  buttons: readonly Pick<GamepadButton, "pressed" | "value">[];
};

/** Indices in W3C Gamepad's "standard gamepad"; on an Xbox's, speed is A and stop is B. */
const BUTTONS = { speed: 0, stop: 1, leftTrigger: 6, rightTrigger: 7, start: 9 } as const;
const CROSS = { forward: 12, back: 13, left: 14, right: 15 };
/** With LB and RB a robot moves sideways, if it can. */
const PLANAR: Record<Direction, number> = { ...CROSS, lateral_left: 4, lateral_right: 5 };

/** A standard gamepad's buttons that must be released; a trigger only beyond the dead zone. */
const LET_GO = [...Array(17).keys()].filter(
  (at) => at !== BUTTONS.leftTrigger && at !== BUTTONS.rightTrigger,
);

export function layoutOf({ mapping, buttons }: Pick<Pad, "mapping" | "buttons">): PadLayout {
  if (buttons.length <= BUTTONS.stop) return "bare";
  return mapping === "standard" && buttons.length > BUTTONS.start ? "standard" : "unknown";
}

/**
 * Reads a gamepad. With an unknown layout only the first stick and the first two buttons count,
 * also for being neutral: a throttle has switches that stay on, and axes that rest at an end. So
 * it never moves a robot sideways. Pure.
 */
export function readPad(pad: Pad, settings: PadSettings, movesSideways: boolean): PadReading {
  const isStandard = pad.mapping === "standard";
  const rest = (at: number) => settings.rests[pad.id]?.[at] ?? 0;
  const axis = (at: number) => fromRest(pad.axes[at] ?? 0, rest(at), settings.deadZone);
  const pressed = (at: number) => pad.buttons[at]?.pressed === true;
  const standard = (at = Number.NaN) => isStandard && pressed(at);
  const trigger = (at: number) =>
    isStandard && settings.triggers ? shapedAxis(pad.buttons[at]?.value ?? 0, settings) : 0;

  const isPlanar = isStandard && movesSideways;
  const turn = isPlanar ? settings.planarTurn : settings.turn;
  const isSplit = isStandard && turn === "right";
  const hasRight = isPlanar || isSplit;
  const hasLeft = isPlanar || !isSplit;
  const left = hasLeft
    ? shaped({ x: axis(0), y: axis(1) }, settings)
    : { x: 0, y: shapedAxis(axis(1), settings) };
  const right = hasRight ? shapedAxis(axis(2), settings) : 0;
  const [turning, sideways] = isSplit ? [right, left.x] : [left.x, right];
  const ahead = trigger(BUTTONS.rightTrigger) - trigger(BUTTONS.leftTrigger) - left.y;
  const motion = {
    linear: Math.max(-1, Math.min(1, ahead)),
    angular: 0 - turning,
    ...(isPlanar && { lateral: 0 - sideways }),
  };
  const buttons: Partial<Record<Direction, number>> = isPlanar ? PLANAR : CROSS;
  const used = isStandard ? LET_GO : [BUTTONS.speed, BUTTONS.stop];
  const triggers = [BUTTONS.leftTrigger, BUTTONS.rightTrigger].filter((at) => trigger(at) !== 0);
  const counting = [...(hasLeft ? [0] : []), ...(hasRight ? [2] : []), 1];
  const sticks = counting.filter((at) => [left.x, left.y, right][at] !== 0);
  // Beside an axis outside the dead zone, one inside it does not count as held.
  const aside = sticks.filter((at) => Math.abs(axis(at)) > settings.deadZone);
  return {
    motion,
    directions: new Set(DIRECTIONS.filter((one) => standard(buttons[one]))),
    stop: pressed(BUTTONS.stop),
    speed: pressed(BUTTONS.speed),
    start: standard(BUTTONS.start),
    held: [
      ...(aside.length > 0 ? aside : sticks).map((at) => ({ kind: "axis" as const, at })),
      ...[...used.filter(pressed), ...triggers].map((at) => ({ kind: "button" as const, at })),
    ],
    axes: counting.map((at) => ({ at, value: pad.axes[at] ?? 0, rest: rest(at) })),
  };
}

/**
 * Maps an axis with this rest to one that rests at 0 and reaches -1…1. However short its travel to
 * an end is, a tremble within the dead zone is not magnified.
 */
function fromRest(said: number, rest: number, deadZone: number): number {
  if (rest === 0) return said;
  const way = Math.max(-1, Math.min(1, said)) - rest;
  if (!(Math.abs(way) > deadZone)) return 0;
  return way / (way > 0 ? 1 - rest : 1 + rest);
}
