/**
 * How a camera on the robot shows the floor: a pinhole that looks ahead and down (pure).
 *
 * A place on the floor is in metres from the point below the lens, `aheadM` and `leftM`; a place in
 * the picture in shares of its width and height, from its upper left corner.
 */

export interface Camera {
  heightM: number;
  tiltDeg: number;
  /** From left to right. */
  fovDeg: number;
  /** Where it looks, as a share of the picture's height. */
  axisRow: number;
}

export interface Floor {
  aheadM: number;
  leftM: number;
}

export interface Spot {
  x: number;
  y: number;
}

/** Anything nearer to the lens than this, along its view, is left out. */
export const NEAR_M = 0.05;

/** The focal length in shares of the picture's height; `aspect` is its width by its height. */
export function focalOf(camera: Camera, aspect: number): number {
  return aspect / 2 / Math.tan(radians(camera.fovDeg) / 2);
}

/** How far a place lies from the lens along its view; behind it is negative. */
export function depthOf(camera: Camera, { aheadM }: Floor): number {
  const tilt = radians(camera.tiltDeg);
  return aheadM * Math.cos(tilt) + camera.heightM * Math.sin(tilt);
}

/** Where a place on the floor is seen; null for what lies behind the lens, or nearly. */
export function project(camera: Camera, aspect: number, floor: Floor): Spot | null {
  const depthM = depthOf(camera, floor);
  if (depthM < NEAR_M) return null;
  const tilt = radians(camera.tiltDeg);
  const downM = camera.heightM * Math.cos(tilt) - floor.aheadM * Math.sin(tilt);
  const focal = focalOf(camera, aspect);
  return {
    x: 0.5 - ((focal / aspect) * floor.leftM) / depthM,
    y: camera.axisRow + (focal * downM) / depthM,
  };
}

/** A line on the floor as the picture shows it: what is behind the lens is cut off. */
export function projectLine(camera: Camera, aspect: number, line: readonly Floor[]): Spot[] {
  const spots: Spot[] = [];
  line.forEach((floor, at) => {
    const before = line[at - 1];
    const crosses =
      before !== undefined && depthOf(camera, before) < NEAR_M !== depthOf(camera, floor) < NEAR_M;
    const edge = crosses ? project(camera, aspect, cut(camera, before, floor)) : null;
    const spot = project(camera, aspect, floor);
    if (edge) spots.push(edge);
    if (spot) spots.push(spot);
  });
  return spots;
}

/** Where the line between two places crosses the nearest distance that is shown. */
function cut(camera: Camera, from: Floor, to: Floor): Floor {
  const start = depthOf(camera, from);
  // Slightly beyond, so that rounding does not leave it out.
  const share = (NEAR_M + 1e-9 - start) / (depthOf(camera, to) - start);
  return {
    aheadM: from.aheadM + (to.aheadM - from.aheadM) * share,
    leftM: from.leftM + (to.leftM - from.leftM) * share,
  };
}

export function radians(degrees: number): number {
  return (degrees * Math.PI) / 180;
}
