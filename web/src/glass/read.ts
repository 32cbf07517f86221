/** Reads the time code in a picture: turned, tilted, dim, mirrored or partly covered. Pure. */

import { cellCentres, HEIGHT, numberOf, STRIP, TO_CENTRE, timeOf, WIDTH } from "./code";
import { type Finder, findersOf, type Grey, type Point } from "./finders";

/** Why no time was read; `between`: the code was just changing, so that the next picture will do. */
export type Miss = "dark" | "nothing" | "cut_off" | "unclear" | "between";
export type Reading = { ms: number } | { miss: Miss };

/** The brightest twentieth of a picture is below this if it is too dark. */
const DARK = 40;
const MOST_FINDERS = 7;
/** Steps a module along the strip. */
const FINE = 4;
/** The share of the strip that must be white before the edge and black behind it. */
const LEAST_STRIP = 0.7;
/** The edge is found within this many modules of where it fits best: it moves during an exposure. */
const NEAR = 5;

/** The brightness at a place of the code; 0 for black, 1 for white. */
type Look = (x: number, y: number) => number;

/** The time that this picture shows, within `REPEATS_MS`, or why none. */
export function read(picture: Grey): Reading {
  const found = findersOf(picture).slice(0, MOST_FINDERS);
  let miss: Miss = found.length >= 3 ? "unclear" : found.length > 0 ? "cut_off" : "nothing";
  for (const corners of quads(found)) {
    for (const turned of placements(corners)) {
      const look = lookThrough(picture, turned);
      const edge = edgeOf(look);
      const number = edge === null ? null : numberSeen(look);
      if (edge === null || number === null) continue;
      const ms = timeOf(number, edge);
      if (ms !== null) return { ms };
      miss = "between";
    }
  }
  return { miss: brightestOf(picture) < DARK ? "dark" : miss };
}

/** All choices of four corners, in order around; then those of three, with the fourth guessed. */
function* quads(found: readonly Finder[]): Generator<Point[]> {
  const fours = choices(found, 4).filter(areAlike);
  for (const four of fours) {
    const x = four.reduce((sum, one) => sum + one.x, 0) / 4;
    const y = four.reduce((sum, one) => sum + one.y, 0) / 4;
    const angle = (one: Point) => Math.atan2(one.y - y, one.x - x);
    yield four.toSorted((a, b) => angle(a) - angle(b));
  }
  for (const three of choices(found, 3).filter(areAlike)) {
    const [a, b, c] = three.toSorted((p, q) => farthest(three, q) - farthest(three, p));
    if (!a || !b || !c) continue;
    // The guessed corner is opposite the one between the two that are farthest apart.
    yield [a, c, b, { x: a.x + b.x - c.x, y: a.y + b.y - c.y }];
  }
}

function farthest(all: readonly Point[], one: Point): number {
  return Math.max(...all.map((other) => Math.hypot(other.x - one.x, other.y - one.y)));
}

function areAlike(chosen: readonly Finder[]): boolean {
  const modules = chosen.map(({ module }) => module);
  return Math.max(...modules) < 2 * Math.min(...modules);
}

function choices<T>(all: readonly T[], count: number): T[][] {
  if (count === 0) return [[]];
  return all.flatMap((one, at) =>
    choices(all.slice(at + 1), count - 1).map((more) => [one, ...more]),
  );
}

/** Every way in which these corners can be the code's, from its top left one clockwise. */
function placements(corners: readonly Point[]): Point[][] {
  return [corners, corners.toReversed()].flatMap((all) =>
    all.map((_, at) => [...all.slice(at), ...all.slice(0, at)]),
  );
}

/** Looks at the code with these corners, between what is black and white at the nearest of them. */
function lookThrough(picture: Grey, corners: readonly Point[]): Look {
  const place = perspective(corners);
  const right = WIDTH - 2 * TO_CENTRE;
  const bottom = HEIGHT - 2 * TO_CENTRE;
  const seen = (x: number, y: number) =>
    brightness(picture, place((x - TO_CENTRE) / right, (y - TO_CENTRE) / bottom));
  const levels = [TO_CENTRE, HEIGHT - TO_CENTRE].flatMap((y) =>
    [TO_CENTRE, WIDTH - TO_CENTRE].map((x) => {
      const white = [seen(x - 2, y), seen(x + 2, y), seen(x, y - 2), seen(x, y + 2)];
      return { black: seen(x, y), white: white.reduce((a, b) => a + b, 0) / 4 };
    }),
  );
  return (x, y) => {
    const u = (x - TO_CENTRE) / right;
    const v = (y - TO_CENTRE) / bottom;
    const shares = [(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v];
    const level = (of: "black" | "white") =>
      levels.reduce((sum, one, at) => sum + one[of] * (shares[at] ?? 0), 0);
    const black = level("black");
    return Math.min(1, Math.max(0, (seen(x, y) - black) / Math.max(1, level("white") - black)));
  };
}

/** The column of the edge; null if the strip is not white before it and black behind it. */
function edgeOf(look: Look): number | null {
  const { top, height } = STRIP;
  const greys = Array.from({ length: WIDTH * FINE }, (_, at) => {
    const rows = [0.25, 0.5, 0.75].map((share) => look((at + 0.5) / FINE, top + share * height));
    return rows.reduce((a, b) => a + b, 0) / rows.length;
  });
  let fit = greys.reduce((sum, grey) => sum + 1 - 2 * grey, 0);
  let best = { fit, at: 0 };
  greys.forEach((grey, at) => {
    fit += 4 * grey - 2;
    if (fit > best.fit) best = { fit, at: at + 1 };
  });
  if (best.fit < LEAST_STRIP * greys.length) return null;
  const near = Math.min(NEAR * FINE, best.at, greys.length - best.at);
  const from = best.at - near;
  const white = greys.slice(from, best.at + near).reduce((a, b) => a + b, 0);
  return (from + white) / FINE;
}

/** The number in the first copy of the cells that checks; null if none does. */
function numberSeen(look: Look): number | null {
  for (const copy of cellCentres()) {
    const greys = copy.map(({ x, y }) => {
      const near = [-0.5, 0, 0.5].flatMap((dx) => [-0.8, 0, 0.8].map((dy) => look(x + dx, y + dy)));
      return near.reduce((a, b) => a + b, 0) / near.length;
    });
    const number = numberOf(greys.map((grey) => grey > 0.5));
    if (number !== null) return number;
  }
  return null;
}

/** Maps the unit square to these corners (Heckbert, 1989, 2.2.3). */
function perspective(corners: readonly Point[]): (u: number, v: number) => Point {
  const [a, b, c, d] = corners as [Point, Point, Point, Point];
  const sum = { x: a.x - b.x + c.x - d.x, y: a.y - b.y + c.y - d.y };
  const one = { x: b.x - c.x, y: b.y - c.y };
  const two = { x: d.x - c.x, y: d.y - c.y };
  const all = one.x * two.y - two.x * one.y || 1;
  const g = (sum.x * two.y - two.x * sum.y) / all;
  const h = (one.x * sum.y - sum.x * one.y) / all;
  return (u, v) => {
    const depth = g * u + h * v + 1;
    return {
      x: ((b.x - a.x + g * b.x) * u + (d.x - a.x + h * d.x) * v + a.x) / depth,
      y: ((b.y - a.y + g * b.y) * u + (d.y - a.y + h * d.y) * v + a.y) / depth,
    };
  };
}

/** The brightness of the pixel there, or of the picture's nearest. */
function brightness({ width, height, data }: Grey, { x, y }: Point): number {
  const column = Math.min(width - 1, Math.max(0, Math.floor(x)));
  const row = Math.min(height - 1, Math.max(0, Math.floor(y)));
  return data[row * width + column] ?? 0;
}

/** How bright the brightest twentieth of the picture is at least. */
function brightestOf({ data }: Grey): number {
  return data.toSorted()[Math.floor(0.95 * data.length)] ?? 0;
}
