/** Reads a gamepad's sticks and buttons; whether they may drive: `gamepad.ts`. Pure. */

import type { ControlInfo } from "../messages";
import { type Response, shaped, shapedAxis } from "./deflection";
import { DIRECTIONS, type Direction, type Motion } from "./inputState";
import { AXIS_USES, type AxisUse, controlUse, isPressed, type Learnt } from "./learntParts";

export interface PadSettings extends Response {
  /** The stick that turns. */
  turn: "left" | "right";
  /** The stick that turns a robot which also moves sideways; the other one moves it so. */
  planarTurn: "left" | "right";
  /** Whether the right trigger drives ahead and the left one back. */
  triggers: boolean;
  /** Where the axes rest, by the gamepad's name; 0 where nothing is stored. */
  rests: Readonly<Record<string, readonly number[]>>;
  /** What the user has taught, by the gamepad's name. */
  learnt: Readonly<Record<string, Learnt>>;
}

/** A gamepad's reading at one moment. */
export interface PadReading {
  motion: Motion;
  /** The directions pressed on the D-pad. */
  directions: ReadonlySet<Direction>;
  stop: boolean;
  speed: boolean;
  start: boolean;
  /** The names of the robot's controls that are pressed. */
  controls: ReadonlySet<string>;
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
/** What an Xbox gamepad has printed on its buttons, in W3C Gamepad's order. */
export const PRINTED: readonly string[] = [
  ...["A", "B", "X", "Y", "LB", "RB", "LT", "RT", "View", "Start", "LS", "RS"],
];
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

/** One of the robot's controls, and the button that presses it on a standard gamepad. */
export type PadControl = Pick<ControlInfo, "name" | "pad_button">;

/**
 * Reads a gamepad. With an unknown layout only the first stick, the first two buttons and what the
 * user has taught count, also for being neutral: a throttle has switches that stay on, and axes
 * that rest at an end. So untaught it never moves a robot sideways. Pure.
 */
export function readPad(
  pad: Pad,
  settings: PadSettings,
  movesSideways: boolean,
  robotControls: readonly PadControl[] = [],
): PadReading {
  const isStandard = pad.mapping === "standard";
  const learnt = settings.learnt[pad.id] ?? {};
  const parts = Object.entries(learnt);
  const rest = (at: number) => settings.rests[pad.id]?.[at] ?? 0;
  const axis = (at: number) => fromRest(pad.axes[at] ?? 0, rest(at), settings.deadZone);
  const pressed = (at: number) => pad.buttons[at]?.pressed === true;
  const isTaught = (kind: PadPart["kind"], at: number) =>
    parts.some(([, part]) => part.kind === kind && part.at === at);
  /** Whether what does this is pressed: the part that was taught, else its usual button. */
  const does = (use: string, at = Number.NaN) => {
    const part = learnt[use];
    return part ? isPressed(pad, part) : pressed(at) && !isTaught("button", at);
  };
  const standard = (at = Number.NaN) => (isStandard ? at : Number.NaN);
  const pushed = (use: AxisUse) => {
    const part = learnt[use];
    if (!part) return null;
    const way = shapedAxis(axis(part.at), settings);
    return part.to < rest(part.at) ? 0 - way : way;
  };
  const trigger = (at: number) =>
    isStandard && settings.triggers && !isTaught("button", at)
      ? shapedAxis(pad.buttons[at]?.value ?? 0, settings)
      : 0;

  const isPlanar = isStandard && movesSideways;
  const turn = isPlanar ? settings.planarTurn : settings.turn;
  const isSplit = isStandard && turn === "right";
  // An axis that was taught something else does nothing of its own.
  const has = (at: number, isUsed: boolean) => isUsed && !isTaught("axis", at);
  const turns = !learnt.turn;
  const slides = isPlanar && !learnt.sideways;
  const hasX = has(0, isSplit ? slides : turns);
  const hasY = has(1, !learnt.ahead);
  const left = shaped({ x: hasX ? axis(0) : 0, y: hasY ? axis(1) : 0 }, settings);
  const hasRight = has(2, isSplit ? turns : slides);
  const right = hasRight ? shapedAxis(axis(2), settings) : 0;
  const [turning, sideways] = isSplit ? [right, left.x] : [left.x, right];
  const ahead = trigger(BUTTONS.rightTrigger) - trigger(BUTTONS.leftTrigger) - left.y;
  const movesLeft = movesSideways && (pushed("sideways") ?? (isPlanar && 0 - sideways));
  const motion = {
    linear: Math.max(-1, Math.min(1, pushed("ahead") ?? ahead)),
    angular: pushed("turn") ?? 0 - turning,
    ...(movesLeft !== false && { lateral: movesLeft }),
  };
  const buttons: Partial<Record<Direction, number>> = isPlanar ? PLANAR : CROSS;
  const taughtAxes = parts.filter(([use]) => isAxisUse(use)).map(([, { at }]) => at);
  // A hat's direction, or another axis that was taught to do what a button does.
  const hats = parts.filter(
    ([use, part]) => !isAxisUse(use) && part.kind === "axis" && isPressed(pad, part),
  );
  const usual = isStandard ? LET_GO : [BUTTONS.speed, BUTTONS.stop];
  const taughtButtons = parts.flatMap(([, { kind, at }]) => (kind === "button" ? [at] : []));
  const used = [...new Set([...usual, ...taughtButtons])];
  const triggers = [BUTTONS.leftTrigger, BUTTONS.rightTrigger].filter((at) => trigger(at) !== 0);
  const own = [...(hasX ? [0] : []), ...(hasRight ? [2] : []), ...(hasY ? [1] : [])];
  const counting = [...new Set([...own, ...taughtAxes])];
  const sticks = counting.filter((at) => {
    const stick = own.includes(at) ? [left.x, left.y, right][at] : shapedAxis(axis(at), settings);
    return stick !== 0;
  });
  // Beside an axis outside the dead zone, one inside it does not count as held.
  const aside = sticks.filter((at) => Math.abs(axis(at)) > settings.deadZone);
  return {
    motion,
    directions: new Set(DIRECTIONS.filter((one) => does(one, standard(buttons[one])))),
    // Like Space, its usual button stops whatever else was taught to.
    stop: does("stop") || does("", BUTTONS.stop),
    speed: does("speed", BUTTONS.speed),
    start: pressed(standard(BUTTONS.start)),
    controls: new Set(
      robotControls
        .filter(({ name, pad_button: button }) =>
          does(controlUse(name), standard(PRINTED.indexOf(button))),
        )
        .map(({ name }) => name),
    ),
    held: [
      ...(aside.length > 0 ? aside : sticks).map((at) => ({ kind: "axis" as const, at })),
      ...hats.map(([, { at }]) => ({ kind: "axis" as const, at })),
      ...[...used.filter(pressed), ...triggers].map((at) => ({ kind: "button" as const, at })),
    ],
    axes: counting.map((at) => ({ at, value: pad.axes[at] ?? 0, rest: rest(at) })),
  };
}

const isAxisUse = (use: string) => AXIS_USES.some((one) => one === use);

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
