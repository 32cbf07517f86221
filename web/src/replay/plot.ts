/** Lines of a plot, in units of its own box. Pure. */

export interface Point {
  atMs: number;
  /** Null where unknown, which breaks the line. */
  value: number | null;
}

export interface Box {
  fromMs: number;
  toMs: number;
  least: number;
  most: number;
  width: number;
  height: number;
}

/** The line as an SVG path; each value holds until the next, and values beyond the box are cut. */
export function steps(points: readonly Point[], box: Box): string {
  const path: string[] = [];
  let before: number | null = null;
  for (const { atMs, value } of points) {
    const x = xOf(atMs, box);
    if (value === null) {
      if (before !== null) path.push(`H${x}`);
      before = null;
      continue;
    }
    const y = yOf(value, box);
    path.push(before === null ? `M${x} ${y}` : `H${x}V${y}`);
    before = y;
  }
  if (before !== null) path.push(`H${box.width}`);
  return path.join("");
}

export function xOf(atMs: number, { fromMs, toMs, width }: Box): number {
  return rounded(clamped((atMs - fromMs) / Math.max(1, toMs - fromMs)) * width);
}

function yOf(value: number, { least, most, height }: Box): number {
  return rounded((1 - clamped((value - least) / (most - least || 1))) * height);
}

/** A round number above all values, for the scale. */
export function scaleFor(values: readonly (number | null)[], least: number): number {
  const most = Math.max(least, ...values.map((one) => (one === null ? 0 : Math.abs(one))));
  const power = 10 ** Math.floor(Math.log10(most));
  return [1, 2, 5, 10].map((one) => one * power).find((one) => one >= most * 0.999) ?? most;
}

function clamped(share: number): number {
  return Math.min(1, Math.max(0, share));
}

function rounded(value: number): number {
  return Math.round(value * 10) / 10;
}
