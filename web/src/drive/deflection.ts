/** The dead zone and the curve of a stick or gamepad: nothing in the middle, then ever more. */
export interface Response {
  /** The share of the way, from 0, in which the stick counts as let go. */
  deadZone: number;
  /** The exponent: 1 answers evenly, more is gentler near the middle. */
  curve: number;
}

/** What a stick says, right and down positive, each in -1…1, as screens and gamepads have it. */
export interface Deflection {
  x: number;
  y: number;
}

/** Answers one axis; what is no number counts as let go. Pure. */
export function shapedAxis(value: number, { deadZone, curve }: Response): number {
  const way = Math.min(1, Math.abs(value));
  if (!(way > deadZone)) return 0;
  return Math.sign(value) * ((way - deadZone) / (1 - deadZone)) ** curve;
}

/** Answers both axes as one, so that the direction stays as it was and the corners are cut. Pure. */
export function shaped({ x, y }: Deflection, response: Response): Deflection {
  const way = Math.hypot(x, y);
  const share = shapedAxis(way, response);
  return share === 0 ? { x: 0, y: 0 } : { x: (x / way) * share, y: (y / way) * share };
}
