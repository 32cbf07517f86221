/** A predicted path as lines in the picture (pure). */

import { type Camera, type Floor, projectLine, type Spot } from "./camera";
import type { Pose } from "./motion";
import type { Prediction } from "./prediction";

export interface Arc {
  /** The edges of the strip that it covers, or its middle if its width is unknown. */
  lanes: Spot[][];
  /** Lines across: the front when the command arrives, and where it would stop. */
  arrival: Spot[];
  stand: Spot[];
}

/** The width of these lines for a robot of unknown width. */
const TICK_M = 0.2;

/**
 * The lines of a path; null if nothing of it is in view. Nobody knows the robot's length: it counts
 * as a square, which covers a strip as broad as itself ahead and sideways, and 1.41 times that on a
 * diagonal.
 */
export function arcOf(
  prediction: Prediction,
  camera: Camera,
  aspect: number,
  widthM: number | null,
): Arc | null {
  const way = [...prediction.until, ...prediction.onwards.slice(1)];
  const half = (widthM ?? 0) / 2;
  const sides = widthM === null ? [0] : [1, -1];
  const axes = axesOf(way);
  const shown = (line: readonly Floor[]) => projectLine(camera, aspect, line);
  const tick = (pose: Pose) => {
    const reach = breadth(half, pose.courseRad);
    const front = beside(pose, pose.courseRad, 0, reach);
    const aside = widthM === null ? TICK_M / 2 : reach;
    return shown([aside, -aside].map((leftM) => beside(front, pose.courseRad, leftM)));
  };
  const arc = {
    lanes: sides.map((side) =>
      shown(
        way.map((pose, at) => {
          const axisRad = axes[at] ?? 0;
          return beside(pose, axisRad, side * breadth(half, axisRad));
        }),
      ),
    ),
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

/** The course at each pose, or its opposite, so that an edge keeps its side when it reverses. */
function axesOf(way: readonly Pose[]): number[] {
  let axisRad = 0;
  return way.map(({ courseRad }) => {
    axisRad = courseRad + Math.PI * Math.round((axisRad - courseRad) / Math.PI);
    return axisRad;
  });
}

/** How far a square reaches to each side of its way; `half` is half its edge. */
function breadth(half: number, courseRad: number): number {
  return half * (Math.abs(Math.cos(courseRad)) + Math.abs(Math.sin(courseRad)));
}

/** A position this far to the left of the robot's way, and ahead of it. */
function beside(pose: Pose, courseRad: number, asideM: number, beforeM = 0): Pose {
  const wayRad = pose.headingRad + courseRad;
  return {
    ...pose,
    aheadM: pose.aheadM + beforeM * Math.cos(wayRad) - asideM * Math.sin(wayRad),
    leftM: pose.leftM + beforeM * Math.sin(wayRad) + asideM * Math.cos(wayRad),
  };
}

function isInPicture({ x, y }: Spot): boolean {
  return x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

function rounded(value: number): number {
  return Math.round(value * 20) / 20;
}
