/** Finds the squares in squares that mark the code's corners, however they are turned. Pure. */

/** A picture's brightness, row by row. */
export interface Grey {
  width: number;
  height: number;
  data: Uint8Array;
}

export interface Point {
  x: number;
  y: number;
}

export interface Finder extends Point {
  /** The length of a module, at most 1.5 times too large where the finder is turned. */
  module: number;
  /** How many rows of the picture cross its middle. */
  rows: number;
}

/** The side of the square over which "brighter than around" is judged, of the picture's width. */
const AROUND = 1 / 6;
/** How much darker than around a pixel must be to count as black. */
const DARKER = 3;
/** The widths of black, white, black, white and black across a finder's middle, in modules. */
const RUNS = [1, 1, 3, 1, 1];

/** The finders in this picture, the surest first. */
export function findersOf(picture: Grey): Finder[] {
  const { width, height } = picture;
  const isBlack = blackened(picture);
  const found: Finder[] = [];
  for (let y = 0; y < height; y++) {
    const runs = [0, 0, 0, 0, 0];
    for (let x = 0, was = 0; x <= width; x++) {
      const is = x < width ? (isBlack[y * width + x] ?? 0) : 1 - was;
      if (x > 0 && is !== was) {
        // Most runs are noise, too short for any finder's middle.
        if (was === 1 && (runs[2] ?? 0) > 2 && isFinder(runs)) {
          const [, , middle = 0, white = 0, black = 0] = runs;
          const one = checked(isBlack, width, height, x - black - white - middle / 2, y, sum(runs));
          if (one) join(found, one);
        }
        runs.shift();
        runs.push(0);
      }
      runs[4] = (runs[4] ?? 0) + 1;
      was = is;
    }
  }
  return found.filter(({ rows }) => rows > 1).toSorted((a, b) => b.rows - a.rows);
}

/** 1 for each pixel that is darker than those around it. */
function blackened({ width, height, data }: Grey): Uint8Array {
  const across = width + 1;
  const sums = new Uint32Array(across * (height + 1));
  for (let y = 0; y < height; y++) {
    for (let x = 0, row = 0; x < width; x++) {
      row += data[y * width + x] ?? 0;
      sums[(y + 1) * across + x + 1] = (sums[y * across + x + 1] ?? 0) + row;
    }
  }
  const black = new Uint8Array(width * height);
  const reach = Math.round((width * AROUND) / 2);
  for (let y = 0; y < height; y++) {
    const [top, bottom] = [Math.max(0, y - reach), Math.min(height, y + reach + 1)];
    for (let x = 0; x < width; x++) {
      const [left, right] = [Math.max(0, x - reach), Math.min(width, x + reach + 1)];
      const total =
        (sums[bottom * across + right] ?? 0) -
        (sums[top * across + right] ?? 0) -
        (sums[bottom * across + left] ?? 0) +
        (sums[top * across + left] ?? 0);
      const mean = total / ((bottom - top) * (right - left));
      black[y * width + x] = Number((data[y * width + x] ?? 0) < mean - DARKER);
    }
  }
  return black;
}

function isFinder(runs: readonly number[]): boolean {
  const module = sum(runs) / 7;
  return (
    module >= 1.5 &&
    RUNS.every((is, at) => Math.abs((runs[at] ?? 0) - is * module) <= 0.6 * module * Math.sqrt(is))
  );
}

/** The finder whose middle a row crosses at `x`, if the column there crosses one as well. */
function checked(
  isBlack: Uint8Array,
  width: number,
  height: number,
  x: number,
  y: number,
  across: number,
): Finder | null {
  const column = Math.floor(x);
  const at = (row: number) => isBlack[row * width + column];
  const runs = [0, 0, 0, 0, 0];
  const follow = (from: number, step: number, first: number) => {
    let row = from;
    for (let run = first, colour = 1; run >= 0 && run < 5; run += step, colour = 1 - colour) {
      while (row >= 0 && row < height && at(row) === colour) {
        runs[run] = (runs[run] ?? 0) + 1;
        row += step;
      }
    }
    return row;
  };
  follow(y - 1, -1, 2);
  const end = follow(y, 1, 2);
  const down = sum(runs);
  if (!isFinder(runs) || down > 2.5 * across || across > 2.5 * down) return null;
  const [, , middle = 0, white = 0, black = 0] = runs;
  const module = Math.sqrt(across * down) / 7;
  return { x, y: end - black - white - middle / 2, module, rows: 1 };
}

/** Adds this sight of a finder to the one seen by other rows, or as a new one. */
function join(found: Finder[], one: Finder): void {
  const known = found.find(({ x, y, module }) => Math.hypot(x - one.x, y - one.y) < 2 * module);
  if (!known) {
    found.push(one);
    return;
  }
  const { rows } = known;
  known.x = (known.x * rows + one.x) / (rows + 1);
  known.y = (known.y * rows + one.y) / (rows + 1);
  known.module = (known.module * rows + one.module) / (rows + 1);
  known.rows = rows + 1;
}

function sum(values: readonly number[]): number {
  return values.reduce((a, b) => a + b, 0);
}
