/**
 * Where the robot will be (pure).
 *
 * A picture shows where the robot was, and a command takes time to arrive. So between the picture
 * and the arrival of the current command, the robot moves by the commands of the last `pictureMs` +
 * `commandMs`.
 */

import {
  courseOf,
  moved,
  type Pose,
  type Ramp,
  ramped,
  STANDSTILL,
  START,
  speedOf,
  type Twist,
} from "./motion";

/** Older commands have no effect: nobody may drive with such a delay. */
const KEPT_MS = 5000;
/** How far ahead the lane is drawn: nearer floor is below many pictures. */
const LOOK_AHEAD_M = 2;
/** A path that turns further than this is cut off. */
const MOST_TURN_RAD = Math.PI / 2;
/** Below this speed the robot stands, or turns on the spot. */
const STANDS_MPS = 0.02;
const STEPS = 12;
/** A curve is drawn as straight segments that turn by this at most. */
const STEP_RAD = 0.1;

export interface Delays {
  /** How old the picture is. */
  pictureMs: number;
  /** The delay of a command on its way to the robot. */
  commandMs: number;
}

export interface Prediction {
  /** From where the picture was taken to where the robot will be when the command arrives. */
  until: Pose[];
  /** From there on, if the command does not change. */
  onwards: Pose[];
  arrival: Pose;
  /** Where the robot stops if everything is released now. */
  stand: Pose;
}

interface Sample {
  atMs: number;
  twist: Twist;
}

/**
 * The commanded speeds as the robot follows them: a sample per change, so that steady driving gives
 * the same path every time, which need not be redrawn.
 */
export class History {
  #samples: Sample[] = [];
  #notedMs = Number.NEGATIVE_INFINITY;

  /** Adds the current command. */
  note(atMs: number, wanted: Twist, ramp: Ramp): void {
    const afterMs = atMs - this.#notedMs;
    if (afterMs <= 0) return;
    if (afterMs >= KEPT_MS) this.clear(); // a robot without commands for this long has stopped
    const last = this.newest;
    const twist =
      this.#samples.length > 0 ? ramped(last, wanted, afterMs / 1000, ramp) : STANDSTILL;
    const isSame =
      twist.linearMps === last.linearMps &&
      twist.angularRps === last.angularRps &&
      twist.lateralMps === last.lateralMps;
    if (!isSame || this.#samples.length === 0) this.#samples.push({ atMs, twist });
    this.#notedMs = atMs;
    // The last sample before the window still counts at its beginning.
    const before = this.#samples.findLastIndex((one) => one.atMs <= atMs - KEPT_MS);
    this.#samples.splice(0, Math.max(0, before));
  }

  /** Forgets everything, as at the beginning of a turn. */
  clear(): void {
    this.#samples = [];
    this.#notedMs = Number.NEGATIVE_INFINITY;
  }

  get newest(): Twist {
    return this.#samples.at(-1)?.twist ?? STANDSTILL;
  }

  /** The path driven between two times, relative to its start. */
  since(fromMs: number, untilMs: number): Pose[] {
    let pose = START;
    const way: Pose[] = [];
    this.#samples.forEach(({ atMs, twist }, at) => {
      const startMs = Math.max(atMs, fromMs);
      const endMs = Math.min(this.#samples[at + 1]?.atMs ?? untilMs, untilMs);
      const forS = (endMs - startMs) / 1000;
      if (forS <= 0 || isStill(twist)) return;
      pose = { ...pose, courseRad: courseOf(twist) };
      if (pose.courseRad !== way.at(-1)?.courseRad) way.push(pose);
      const steps = Math.max(1, Math.ceil(Math.abs(twist.angularRps * forS) / STEP_RAD));
      for (let step = 0; step < steps; step++) {
        pose = moved(pose, twist, forS / steps);
        way.push(pose);
      }
    });
    return way.length > 0 ? way : [START];
  }
}

function isStill(twist: Twist): boolean {
  return speedOf(twist) === 0 && twist.angularRps === 0;
}

/** Predicts the robot's path; null while it stands, or turns on the spot. */
export function predict(
  history: History,
  nowMs: number,
  { pictureMs, commandMs }: Delays,
  brakingMps2: number,
): Prediction | null {
  const until = history.since(nowMs - pictureMs - commandMs, nowMs);
  const arrival = until.at(-1) ?? START;
  const twist = history.newest;
  const isUnderWay = speedOf(twist) >= STANDS_MPS;
  const hasMoved = Math.hypot(arrival.aheadM, arrival.leftM) >= STANDS_MPS / 10;
  if (!isUnderWay && !hasMoved) return null;
  if (!isUnderWay) return { until, onwards: [], arrival, stand: arrival };
  return {
    until,
    onwards: onwards(arrival, twist),
    arrival,
    // It brakes along its current arc.
    stand: moved(arrival, twist, speedOf(twist) / (2 * brakingMps2)),
  };
}

/** The lane from there on, equally long at every speed: it shows a curve, not a time. */
function onwards(from: Pose, twist: Twist): Pose[] {
  const turnS = MOST_TURN_RAD / Math.max(Math.abs(twist.angularRps), 1e-6);
  const forS = Math.min(LOOK_AHEAD_M / speedOf(twist), turnS);
  return Array.from({ length: STEPS + 1 }, (_, step) => moved(from, twist, (forS * step) / STEPS));
}
