import { type Response, shaped, shapedAxis } from "./deflection";
import { DIRECTIONS, type Direction, type Motion } from "./inputState";

export interface PadSettings extends Response {
  /** The stick that turns. */
  turn: "left" | "right";
  /** Whether the right trigger goes ahead and the left one back. */
  triggers: boolean;
}

/** What a gamepad says at one moment. */
export interface PadReading {
  motion: Motion;
  /** The directions of its cross. */
  directions: ReadonlySet<Direction>;
  stop: boolean;
  speed: boolean;
  start: boolean;
  /** Whether nothing on it is touched. */
  isNeutral: boolean;
}

export type Pad = Pick<Gamepad, "axes" | "mapping"> & {
  buttons: readonly Pick<GamepadButton, "pressed" | "value">[];
};

/** Places in the "standard gamepad" of W3C Gamepad: A, B and Start by their names on an Xbox's. */
const BUTTONS = { speed: 0, stop: 1, leftTrigger: 6, rightTrigger: 7, start: 9 } as const;
const CROSS: Record<Direction, number> = { forward: 12, back: 13, left: 14, right: 15 };

/** Of a gamepad with an unknown layout only the first stick and the first two buttons count. Pure. */
export function readPad(pad: Pad, settings: PadSettings): PadReading {
  const isStandard = pad.mapping === "standard";
  const axis = (at: number) => pad.axes[at] ?? 0;
  const pressed = (at: number) => pad.buttons[at]?.pressed === true;
  const standard = (at: number) => isStandard && pressed(at);
  const trigger = (at: number) =>
    isStandard && settings.triggers ? shapedAxis(pad.buttons[at]?.value ?? 0, settings) : 0;

  const stick =
    isStandard && settings.turn === "right"
      ? { x: shapedAxis(axis(2), settings), y: shapedAxis(axis(1), settings) }
      : shaped({ x: axis(0), y: axis(1) }, settings);
  const ahead = trigger(BUTTONS.rightTrigger) - trigger(BUTTONS.leftTrigger) - stick.y;
  const motion = { linear: Math.max(-1, Math.min(1, ahead)), angular: 0 - stick.x };
  const areTriggersLoose = trigger(BUTTONS.rightTrigger) + trigger(BUTTONS.leftTrigger) === 0;
  const isAtRest = motion.linear === 0 && motion.angular === 0 && areTriggersLoose;
  return {
    motion,
    directions: new Set(DIRECTIONS.filter((one) => standard(CROSS[one]))),
    stop: pressed(BUTTONS.stop),
    speed: pressed(BUTTONS.speed),
    start: standard(BUTTONS.start),
    isNeutral: isAtRest && !pad.buttons.some((button) => button.pressed),
  };
}
