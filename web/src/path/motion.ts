/** How a robot moves: on arcs, accelerating within its own limits (pure). */

/** Metres and radians a second; ahead and left are positive. */
export interface Twist {
  linearMps: number;
  angularRps: number;
}

/** Relative to the start: metres ahead and to the left, and how far it has turned left. */
export interface Pose {
  aheadM: number;
  leftM: number;
  headingRad: number;
}

export interface Ramp {
  accelerationMps2: number;
  accelerationRps2: number;
}

export const STANDSTILL: Twist = { linearMps: 0, angularRps: 0 };
export const START: Pose = { aheadM: 0, leftM: 0, headingRad: 0 };

/** A smaller turn counts as straight, to avoid dividing by zero. */
const STRAIGHT_RAD = 1e-6;

/** The pose after moving at this twist for a time. */
export function moved(from: Pose, { linearMps, angularRps }: Twist, forS: number): Pose {
  return along(from, linearMps * forS, angularRps * forS);
}

/** The pose at the end of an arc of this length and turn. */
export function along(from: Pose, lengthM: number, turnRad: number): Pose {
  const half = turnRad / 2;
  // The chord; for a nearly straight arc, as long as the arc.
  const chordM = Math.abs(half) < STRAIGHT_RAD ? lengthM : (lengthM * Math.sin(half)) / half;
  const towards = from.headingRad + half;
  return {
    aheadM: from.aheadM + chordM * Math.cos(towards),
    leftM: from.leftM + chordM * Math.sin(towards),
    headingRad: from.headingRad + turnRad,
  };
}

/** The speed after a time, on its way to the commanded one: it rises slowly and falls at once. */
export function ramped(now: Twist, wanted: Twist, afterS: number, ramp: Ramp): Twist {
  return {
    linearMps: part(now.linearMps, wanted.linearMps, ramp.accelerationMps2 * afterS),
    angularRps: part(now.angularRps, wanted.angularRps, ramp.accelerationRps2 * afterS),
  };
}

function part(now: number, wanted: number, most: number): number {
  // The part of the speed that the command keeps; the rest is dropped at once, as on the server.
  const kept =
    Math.sign(now) === Math.sign(wanted)
      ? Math.sign(now) * Math.min(Math.abs(now), Math.abs(wanted))
      : 0;
  return kept + Math.max(-most, Math.min(most, wanted - kept));
}
