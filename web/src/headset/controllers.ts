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
  /** Whether there is a controller that can drive. */
  isThere: boolean;
  /** The hands that press their Stop. */
  stops: ReadonlySet<XRHandedness>;
  /** Whether a trigger is pressed. */
  isTriggered: boolean;
  /** Whether a grip is squeezed. */
  isSqueezed: boolean;
  /** Whether that is the dead-man: only if both grips were open since the robot may be moved. */
  isEnabling: boolean;
  /** Where the right stick pushes the camera; null while it turns the robot. */
  pan: { left: number; up: number } | null;
}

/**
 * The right stick pans while the right trigger is pressed, and from then on until the stick has been
 * let go, lest the robot turn when the trigger is released first.
 */
export class Controllers {
  #isPanning = false;
  #wasOpen = false;
  #there = "";

  /** `mayMove` is whether the robot may be moved now. */
  read(all: Iterable<Controller>, response: Response, mayMove: boolean): Hands {
    const hands: { left?: Pad; right?: Pad } = {};
    for (const { handedness, gamepad } of all) {
      // One that has no button left for Stop, as a bare hand, does not drive.
      const isWhole = gamepad?.mapping === "xr-standard" && gamepad.buttons.length > SQUEEZE + 1;
      if (isWhole && handedness !== "none") hands[handedness] = gamepad;
    }
    const { left, right } = hands;
    const both = [left, right].filter((hand) => hand !== undefined);
    const there = Object.keys(hands).sort().join();
    const stops = new Set(
      (["left", "right"] as const).filter((side) => {
        const hand = hands[side];
        return hand && isPressed(hand, stopOf(hand));
      }),
    );
    const isSqueezed = both.some((hand) => isPressed(hand, SQUEEZE));
    // One that comes back may be pushed: it is as if all were taken anew.
    if (!mayMove || there !== this.#there) this.#wasOpen = false;
    else this.#wasOpen ||= !isSqueezed;
    this.#there = there;
    const isEnabling = isSqueezed && this.#wasOpen;
    const turning = stickOf(right);
    const isAside = turning.some((value) => shapedAxis(value, response) !== 0);
    this.#isPanning = isPressed(right, TRIGGER) || (this.#isPanning && isAside);
    const [across = 0, along = 0] = turning.map((value) => shapedAxis(value, response));
    const buttons = Array.from({ length: STANDARD.count }, (_, at) => {
      const pressed =
        (at === STANDARD.stop && stops.size > 0) ||
        (at === STANDARD.a && isOwn(right) && isPressed(right, LOWER)) ||
        (at === STANDARD.x && isOwn(left) && isPressed(left, LOWER));
      return { pressed, value: Number(pressed) };
    });
    const said = both.flatMap(({ axes, buttons: own }) => [
      ...axes,
      ...own.map(({ value }) => value),
    ]);
    const sticks = [...stickOf(left), ...(this.#isPanning ? [0, 0] : turning)];
    return {
      // The rest is not read, and shows that the controllers are alive (`padRest.ts`).
      pad: { id: "headset", mapping: "standard", axes: [...sticks, ...said], buttons },
      isThere: both.length > 0,
      stops,
      isTriggered: both.some((hand) => isPressed(hand, TRIGGER)),
      isSqueezed,
      isEnabling,
      pan: this.#isPanning && isEnabling ? { left: 0 - across, up: 0 - along } : null,
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
