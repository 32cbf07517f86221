/** Reads a headset's two controllers as one gamepad; when that drives: `../drive/gamepad.ts`. */

import { type Response, shapedAxis } from "../drive/deflection";
import type { Pad } from "../drive/padReading";

export type Controller = Pick<XRInputSource, "handedness"> & { readonly gamepad?: Pad | undefined };

/** Buttons of "xr-standard" (WebXR Gamepads Module, 3.3), and what Touch controllers have there. */
const TRIGGER = 0;
const SQUEEZE = 1;
const LOWER = 4;
const UPPER = 5;
/** W3C Gamepad's "standard gamepad", as which a user's settings and `[[controls]]` know a pad. */
const STANDARD = { a: 0, stop: 1, x: 2, count: 17 };

/** What both hands say at one moment. */
export interface Hands {
  /** As a standard gamepad: the left stick, the right one unless it pans, A, X and Stop. */
  pad: Pad;
  /** Whether the dead-man is held, by either hand. */
  isSqueezed: boolean;
  /** Where the right stick pushes the camera; null while it turns the robot. */
  pan: { left: number; up: number } | null;
}

/**
 * The right stick pans while the right trigger is pressed, and from then on until the stick has been
 * let go, lest the robot turn when the trigger is released first.
 */
export class Controllers {
  #isPanning = false;

  read(all: Iterable<Controller>, response: Response): Hands {
    const hands: { left?: Pad; right?: Pad } = {};
    for (const { handedness, gamepad } of all) {
      // One that has no button left for Stop, as a bare hand, does not drive.
      const isWhole = gamepad?.mapping === "xr-standard" && gamepad.buttons.length > SQUEEZE + 1;
      if (isWhole && handedness !== "none") hands[handedness] = gamepad;
    }
    const { left, right } = hands;
    const stops = [left, right].some((hand) => hand && isPressed(hand, stopOf(hand)));
    const isSqueezed = isPressed(left, SQUEEZE) || isPressed(right, SQUEEZE);
    const turning = stickOf(right);
    const isAside = turning.some((value) => shapedAxis(value, response) !== 0);
    this.#isPanning = isPressed(right, TRIGGER) || (this.#isPanning && isAside);
    const [across = 0, along = 0] = turning.map((value) => shapedAxis(value, response));
    const buttons = Array.from({ length: STANDARD.count }, (_, at) => {
      const pressed =
        (at === STANDARD.stop && stops) ||
        (at === STANDARD.a && isOwn(right) && isPressed(right, LOWER)) ||
        (at === STANDARD.x && isOwn(left) && isPressed(left, LOWER));
      return { pressed, value: Number(pressed) };
    });
    const said = [left, right].flatMap((hand) => [
      ...(hand?.axes ?? []),
      ...(hand?.buttons.map(({ value }) => value) ?? []),
    ]);
    const sticks = [...stickOf(left), ...(this.#isPanning ? [0, 0] : turning)];
    return {
      // The rest is not read, and shows that the controllers are alive (`padRest.ts`).
      pad: { id: "headset", mapping: "standard", axes: [...sticks, ...said], buttons },
      isSqueezed,
      pan: this.#isPanning && isSqueezed ? { left: 0 - across, up: 0 - along } : null,
    };
  }
}

/** The upper button (B or Y); on a controller with fewer, the last one. */
const stopOf = ({ buttons }: Pad) => Math.min(UPPER, buttons.length - 1);

/** Whether its lower button (A or X) is another than its Stop. */
const isOwn = (hand: Pad | undefined) => hand !== undefined && stopOf(hand) === UPPER;

function isPressed(hand: Pad | undefined, at: number): boolean {
  return hand?.buttons[at]?.pressed === true;
}

/** A thumbstick's axes follow a touch pad's, present or not; without a stick the pad counts. */
function stickOf(hand: Pad | undefined): number[] {
  const { axes = [] } = hand ?? {};
  const [x = 0, y = 0] = axes.length > 3 ? axes.slice(2) : axes;
  return [x, y];
}
