import type { Twist } from "../path/motion";

export function twist(linearMps: number, angularRps: number, lateralMps = 0): Twist {
  return { linearMps, angularRps, lateralMps };
}
