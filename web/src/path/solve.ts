/**
 * A camera's tilt and field of view from two points on the floor (pure).
 *
 * Both lie straight ahead, at known distances from the point below the lens, whose height is known.
 * With the angles `a` and `b` of the two lines of sight below the level, their mean below the lens's
 * axis being m, and f the focal length, the rows are f·tan(m + (a − b)/2) and f·tan(m − (a − b)/2).
 * Their sum over their difference is sin 2m / sin(a − b), which leaves m alone.
 */

import type { Code } from "../words/words";
import type { Camera } from "./camera";

export interface Seen {
  /** From the point on the floor below the lens. */
  distanceM: number;
  /** Its row in the picture, as a share of the picture's height from the top. */
  row: number;
}

export type Solution = { is: "found"; camera: Camera } | { is: "impossible"; why: Code };

/** As in the configuration. */
const TILT_DEG = { least: -30, most: 80 } as const;
const FOV_DEG = { least: 10, most: 170 } as const;
const HEIGHT_M = { least: 0.02, most: 5 } as const;
/** Points closer together in the picture than this determine nothing. */
const LEAST_ROWS = 0.02;
const AXIS_ROW = 0.5;

/** `aspect` is the picture's width by its height; its pixels are square. */
export function solve(heightM: number, near: Seen, far: Seen, aspect: number): Solution {
  const isHigh = heightM >= HEIGHT_M.least && heightM <= HEIGHT_M.most;
  const isApart = near.distanceM > 0 && far.distanceM > near.distanceM;
  // Also true for NaN.
  if (!isHigh) return { is: "impossible", why: "path.bad_height" };
  if (!isApart) return { is: "impossible", why: "path.bad_distances" };
  if (!(near.row - far.row >= LEAST_ROWS)) return { is: "impossible", why: "path.bad_points" };
  const nearRad = Math.atan2(heightM, near.distanceM);
  const farRad = Math.atan2(heightM, far.distanceM);
  const below = near.row - AXIS_ROW;
  const above = far.row - AXIS_ROW;
  const sine = (Math.sin(nearRad - farRad) * (below + above)) / (below - above);
  if (Math.abs(sine) > 1) return { is: "impossible", why: "path.no_camera" };
  const tilt = (nearRad + farRad - Math.asin(sine)) / 2;
  const slope = Math.tan(nearRad - tilt) - Math.tan(farRad - tilt);
  const focal = (below - above) / slope;
  const tiltDeg = degrees(tilt);
  const fovDeg = degrees(2 * Math.atan(aspect / 2 / focal));
  const isCamera =
    focal > 0 &&
    tiltDeg >= TILT_DEG.least &&
    tiltDeg <= TILT_DEG.most &&
    fovDeg >= FOV_DEG.least &&
    fovDeg <= FOV_DEG.most;
  if (!isCamera) return { is: "impossible", why: "path.no_camera" };
  return { is: "found", camera: { heightM, tiltDeg, fovDeg, axisRow: AXIS_ROW } };
}

/** The lines for the configuration. */
export function configurationOf({ heightM, tiltDeg, fovDeg }: Camera): string {
  return [
    "[video]",
    `camera_height_m = ${written(heightM, 3)}`,
    `camera_tilt_deg = ${written(tiltDeg, 1)}`,
    `camera_fov_deg = ${written(fovDeg, 1)}`,
  ].join("\n");
}

/** A number with a decimal point, whatever the language; never -0.0. */
function written(value: number, digits: number): string {
  return (value + 0).toFixed(digits).replace(/^-(0\.0+)$/, "$1");
}

function degrees(radians: number): number {
  return (radians * 180) / Math.PI;
}
