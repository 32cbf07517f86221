/** How a robot moves: on arcs, accelerating within its own limits (pure). */

/** Metres and radians a second; ahead, turning left and sideways to the left are positive. */
export interface Twist {
  linearMps: number;
  angularRps: number;
  lateralMps: number;
}

/**
 * Relative to the start: metres ahead and to the left, and how far it has turned left. `courseRad`
 * is the direction in which it moves there, counted to the left from where it looks; 0 for a robot
 * that does not move sideways, even while it reverses.
 */
export interface Pose {
  aheadM: number;
  leftM: number;
  headingRad: number;
  courseRad: number;
}

export interface Ramp {
  accelerationMps2: number;
  accelerationRps2: number;
}

export const STANDSTILL: Twist = { linearMps: 0, angularRps: 0, lateralMps: 0 };
export const START: Pose = { aheadM: 0, leftM: 0, headingRad: 0, courseRad: 0 };

/** A smaller turn counts as straight, to avoid dividing by zero. */
const STRAIGHT_RAD = 1e-6;

export function speedOf({ linearMps, lateralMps }: Twist): number {
  return Math.hypot(linearMps, lateralMps);
}

/** The direction in which a robot moves, as in `Pose`. */
export function courseOf({ linearMps, lateralMps }: Twist): number {
  return lateralMps === 0 ? 0 : Math.atan2(lateralMps, linearMps);
}

/** The pose after moving at this twist for a time. */
export function moved(from: Pose, twist: Twist, forS: number): Pose {
  const turnRad = twist.angularRps * forS;
  const half = turnRad / 2;
  // The chord of the arc, by its length; a nearly straight arc is as long.
  const chord = Math.abs(half) < STRAIGHT_RAD ? forS : (forS * Math.sin(half)) / half;
  const towards = from.headingRad + half;
  const [aheadM, leftM] = [twist.linearMps * chord, twist.lateralMps * chord];
  return {
    aheadM: from.aheadM + aheadM * Math.cos(towards) - leftM * Math.sin(towards),
    leftM: from.leftM + aheadM * Math.sin(towards) + leftM * Math.cos(towards),
    headingRad: from.headingRad + turnRad,
    courseRad: courseOf(twist),
  };
}

/** The twist after a time, on its way to the commanded one, by the server's rule (`ramp.py`). */
export function ramped(now: Twist, wanted: Twist, afterS: number, ramp: Ramp): Twist {
  const [linearMps, lateralMps] = vector(
    [now.linearMps, now.lateralMps],
    [wanted.linearMps, wanted.lateralMps],
    ramp.accelerationMps2 * afterS,
  );
  const [angularRps] = vector(
    [now.angularRps, 0],
    [wanted.angularRps, 0],
    ramp.accelerationRps2 * afterS,
  );
  return { linearMps, angularRps, lateralMps };
}

type Vector = [number, number];

/** Drops at once what `wanted` does not keep of the speed, then gains at most so much. */
function vector(now: Vector, wanted: Vector, most: number): Vector {
  const speed = Math.hypot(...now) || 1;
  const way: Vector = [now[0] / speed, now[1] / speed];
  const kept = Math.max(0, Math.min(speed, wanted[0] * way[0] + wanted[1] * way[1]));
  const from: Vector = [way[0] * kept, way[1] * kept];
  const rest: Vector = [wanted[0] - from[0], wanted[1] - from[1]];
  const part = most / Math.hypot(...rest);
  return part < 1 ? [from[0] + rest[0] * part, from[1] + rest[1] * part] : wanted;
}
