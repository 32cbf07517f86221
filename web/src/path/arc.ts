/** A predicted path as lines in the picture (pure). */

import { type Camera, type Floor, projectLine, type Spot } from "./camera";
import type { Pose } from "./motion";
import type { Prediction } from "./prediction";

export interface Arc {
  /** The robot's edges, or its middle if its width is unknown. */
  lanes: Spot[][];
  /** Lines across: the front when the command arrives, and where it would stop. */
  arrival: Spot[];
  stand: Spot[];
}

/** The width of these lines for a robot of unknown width. */
const TICK_M = 0.2;

/** The lines of a path; null if nothing of it is in view. */
export function arcOf(
  prediction: Prediction,
  camera: Camera,
  aspect: number,
  widthM: number | null,
): Arc | null {
  const way = [...prediction.until, ...prediction.onwards.slice(1)];
  const half = (widthM ?? 0) / 2;
  const sides = widthM === null ? [0] : [half, -half];
  const shown = (line: readonly Floor[]) => projectLine(camera, aspect, line);
  const tick = (pose: Pose) => {
    const front = beside(pose, 0, half);
    const reach = widthM === null ? TICK_M / 2 : half;
    return shown([beside(front, reach), beside(front, -reach)]);
  };
  const arc = {
    lanes: sides.map((leftM) => shown(way.map((pose) => beside(pose, leftM)))),
    arrival: tick(prediction.arrival),
    stand: tick(prediction.stand),
  };
  const isInView = [...arc.lanes.flat(), ...arc.arrival, ...arc.stand].some(isInPicture);
  return isInView ? arc : null;
}

/** The SVG path of a line in a box of 100 by 100, empty for less than two spots. */
export function pathData(line: readonly Spot[]): string {
  if (line.length < 2) return "";
  const points = line.map(({ x, y }) => `${rounded(100 * x)} ${rounded(100 * y)}`);
  return `M${points.join("L")}`;
}

/** A position beside the robot, and this far ahead of it. */
function beside({ aheadM, leftM, headingRad }: Pose, asideM: number, beforeM = 0): Pose {
  return {
    aheadM: aheadM + beforeM * Math.cos(headingRad) - asideM * Math.sin(headingRad),
    leftM: leftM + beforeM * Math.sin(headingRad) + asideM * Math.cos(headingRad),
    headingRad,
  };
}

function isInPicture({ x, y }: Spot): boolean {
  return x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

function rounded(value: number): number {
  return Math.round(value * 20) / 20;
}
