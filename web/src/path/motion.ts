/** How a robot moves: on arcs, faster and slower by its own limits (pure). */

/** Metres and radians a second; ahead and left are positive. */
export interface Twist {
  linearMps: number;
  angularRps: number;
}

/** From where it was: metres ahead and to the left, and how far it has turned left. */
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

/** A turn by less than this is straight ahead for the formula of an arc. */
const STRAIGHT_RAD = 1e-6;

/** Where a robot is after it has moved so for a time. */
export function moved(from: Pose, { linearMps, angularRps }: Twist, forS: number): Pose {
  return along(from, linearMps * forS, angularRps * forS);
}

/** Where a robot is at the end of an arc of this length, on which it turns so far. */
export function along(from: Pose, lengthM: number, turnRad: number): Pose {
  const half = turnRad / 2;
  // The chord, which is as long as the arc while that is nearly straight.
  const chordM = Math.abs(half) < STRAIGHT_RAD ? lengthM : (lengthM * Math.sin(half)) / half;
  const towards = from.headingRad + half;
  return {
    aheadM: from.aheadM + chordM * Math.cos(towards),
    leftM: from.leftM + chordM * Math.sin(towards),
    headingRad: from.headingRad + turnRad,
  };
}

/** The speed after a time, on the way to what is commanded: it rises slowly and falls at once. */
export function ramped(now: Twist, wanted: Twist, afterS: number, ramp: Ramp): Twist {
  return {
    linearMps: part(now.linearMps, wanted.linearMps, ramp.accelerationMps2 * afterS),
    angularRps: part(now.angularRps, wanted.angularRps, ramp.accelerationRps2 * afterS),
  };
}

function part(now: number, wanted: number, most: number): number {
  // What of the speed the command keeps; the rest is gone in one step, as the server does it.
  const kept =
    Math.sign(now) === Math.sign(wanted)
      ? Math.sign(now) * Math.min(Math.abs(now), Math.abs(wanted))
      : 0;
  return kept + Math.max(-most, Math.min(most, wanted - kept));
}
