/** The dead zone and the response curve of a stick or gamepad. */
export interface Response {
  /** The share of the travel, from 0, in which the stick counts as released. */
  deadZone: number;
  /** The exponent: 1 is linear, more is gentler near the middle. */
  curve: number;
}

/** A stick's position, right and down positive, each in -1…1, as on screens and gamepads. */
export interface Deflection {
  x: number;
  y: number;
}

/** Applies the response to one axis; NaN counts as released. Pure. */
export function shapedAxis(value: number, { deadZone, curve }: Response): number {
  const way = Math.min(1, Math.abs(value));
  if (!(way > deadZone)) return 0;
  return Math.sign(value) * ((way - deadZone) / (1 - deadZone)) ** curve;
}

/** Applies the response to both axes together: keeps the direction, cuts the corners. Pure. */
export function shaped({ x, y }: Deflection, response: Response): Deflection {
  const way = Math.hypot(x, y);
  const share = shapedAxis(way, response);
  return share === 0 ? { x: 0, y: 0 } : { x: (x / way) * share, y: (y / way) * share };
}
