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

/** A point's distance from the middle as a share of the radius, limited to the rim. Pure. */
export function deflectionAt(place: Place, x: number, y: number): Deflection {
  const [right, down] = [(x - place.x) / place.radius, (y - place.y) / place.radius];
  const way = Math.max(1, Math.hypot(right, down));
  return { x: right / way, y: down / way };
}

/** The motion that a stick on the screen asks for; ahead and left are positive. Pure. */
export function motionOf(deflection: Deflection, response: Response = RESPONSE): Motion {
  const { x, y } = shaped(deflection, response);
  return { linear: 0 - y, angular: 0 - x };
}
