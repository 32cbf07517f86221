/** What a calibrated camera would see of a floor with lines on it (pure). */

import { pathData } from "./arc";
import { type Camera, projectLine } from "./camera";

const EVERY_M = 0.5;
const LINES = 6;
/** Half the length of a cross line if the robot's width is unknown. */
const HALF_M = 0.25;
/** Nearer than this the floor is below most pictures. */
const FROM_M = 0.1;

/** The SVG path, in a box of 100 by 100: the robot's lane, and a line across each half metre. */
export function gridOf(camera: Camera, aspect: number, widthM: number | null): string {
  const half = widthM ? widthM / 2 : HALF_M;
  const shown = (line: readonly (readonly [number, number])[]) =>
    pathData(
      projectLine(
        camera,
        aspect,
        line.map(([aheadM, leftM]) => ({ aheadM, leftM })),
      ),
    );
  const across = Array.from({ length: LINES }, (_, at) => EVERY_M * (at + 1));
  return [
    ...[half, -half].map((leftM) =>
      shown([
        [FROM_M, leftM],
        [EVERY_M * LINES, leftM],
      ]),
    ),
    ...across.map((aheadM) =>
      shown([
        [aheadM, half],
        [aheadM, -half],
      ]),
    ),
  ].join("");
}
