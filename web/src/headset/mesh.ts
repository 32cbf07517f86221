/** Screens around the head, which is at the origin and looks along -z. Pure. */

const RADIANS = Math.PI / 180;
const STRIPS = 24;
/** A picture that sees more is shown narrower: farther aside nobody looks. */
const WIDEST_DEG = 130;

export interface Screen {
  /** From its left edge to its right one. */
  acrossDeg: number;
  /** Its width by its height. */
  aspect: number;
  distanceM: number;
  /** Whether every place of a row is at that distance, not only its middle. */
  isCurved: boolean;
  /** Where its middle is: right and up are positive. */
  yawDeg?: number;
  pitchDeg?: number;
}

/** From a screen's middle to its upper edge, in degrees. */
export function halfHeightDeg({ acrossDeg, aspect }: Screen): number {
  return Math.atan(Math.tan((acrossDeg / 2) * RADIANS) / aspect) / RADIANS;
}

/**
 * A triangle strip of places, in metres, and spots in the picture: x, y, z, u, v. From the origin,
 * flat or curved, every spot is seen where a pinhole camera with that field of view saw it.
 */
export function meshOf({ yawDeg = 0, pitchDeg = 0, ...screen }: Screen): Float32Array {
  const { aspect, distanceM, isCurved } = screen;
  const across = Math.min(screen.acrossDeg, WIDEST_DEG) * RADIANS;
  const [halfWidth, yaw, pitch] = [Math.tan(across / 2), yawDeg * RADIANS, pitchDeg * RADIANS];
  const places: number[] = [];
  for (let strip = 0; strip <= STRIPS; strip++) {
    const at = (strip / STRIPS - 0.5) * across;
    const ahead = distanceM * (isCurved ? Math.cos(at) : 1);
    for (const v of [0, 1]) {
      const x = ahead * Math.tan(at);
      const y = (ahead * halfWidth * (1 - 2 * v)) / aspect;
      const [raised, behind] = turned(y, -ahead, pitch);
      const u = 0.5 + Math.tan(at) / halfWidth / 2;
      const [aside, back] = turned(x, behind, yaw);
      places.push(aside, raised, back, u, v);
    }
  }
  return new Float32Array(places);
}

function turned(a: number, b: number, by: number): [number, number] {
  return [a * Math.cos(by) - b * Math.sin(by), a * Math.sin(by) + b * Math.cos(by)];
}

/** The product of two 4×4 matrices, in columns as WebGL has them. */
export function product(a: Float32Array, b: Float32Array): Float32Array {
  return Float32Array.from({ length: 16 }, (_, at) => {
    const [row, column] = [at % 4, at - (at % 4)];
    return [0, 1, 2, 3].reduce((sum, i) => sum + (a[row + 4 * i] ?? 0) * (b[column + i] ?? 0), 0);
  });
}
