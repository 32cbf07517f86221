import { type Deflection, type Response, shaped } from "./deflection";
import type { Motion } from "./inputState";

/** Where the stick is on the screen. */
export interface Place {
  x: number;
  y: number;
  /** How far its knob goes. */
  radius: number;
}

/** The dead zone allows for a thumb that merely rests on the middle. */
const RESPONSE: Response = { deadZone: 0.12, curve: 1.5 };

/**
 * A point's distance from the middle as a share of the radius, limited to the rim; one that only
 * turns goes only left and right. Pure.
 */
export function deflectionAt(
  place: Place,
  x: number,
  y: number,
  use: StickUse = "drive",
): Deflection {
  const right = (x - place.x) / place.radius;
  const down = use === "turn" ? 0 : (y - place.y) / place.radius;
  const way = Math.max(1, Math.hypot(right, down));
  return { x: right / way, y: down / way };
}

/** What a stick does: drive and turn, move in all directions, or only turn. */
export type StickUse = "drive" | "move" | "turn";

/** The motion that a stick on the screen asks for; ahead and left are positive. Pure. */
export function motionOf(
  deflection: Deflection,
  use: StickUse = "drive",
  response: Response = RESPONSE,
): Motion {
  const { x, y } = shaped(deflection, response);
  if (use === "move") return { linear: 0 - y, angular: 0, lateral: 0 - x };
  return { linear: 0 - y, angular: 0 - x };
}
