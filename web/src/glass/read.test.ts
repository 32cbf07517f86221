import { expect, it } from "vitest";
import { numbers } from "../testing/random";
import { HEIGHT, MARGIN, PERIOD_MS, patches, REPEATS_MS, WIDTH } from "./code";
import type { Grey } from "./finders";
import { read } from "./read";

/** How a camera sees a screen with the code. Angles are in radians, light in the picture's grey. */
interface Scene {
  width: number;
  height: number;
  /** How much of the picture's width the code fills, where it is not turned. */
  share: number;
  turned: number;
  /** How far the screen is tilted backwards, and aside. */
  back: number;
  aside: number;
  isMirrored: boolean;
  black: number;
  white: number;
  noise: number;
  exposureMs: number;
  /** The middle of the code, in the picture, from -1 to 1. */
  x: number;
  y: number;
  /** What covers the code: left, top, width and height in its modules. */
  covered: readonly [number, number, number, number] | null;
}

const PLAIN: Scene = {
  width: 480,
  height: 270,
  share: 0.5,
  turned: 0,
  back: 0,
  aside: 0,
  isMirrored: false,
  black: 16,
  white: 235,
  noise: 0,
  exposureMs: 0,
  x: 0,
  y: 0,
  covered: null,
};
const SCALE = 10;
const ACROSS = (WIDTH + 2 * MARGIN) * SCALE;
const DOWN = (HEIGHT + 2 * MARGIN) * SCALE;
const WALL = 0.45;
const REFRESH_MS = 1000 / 60;

/** What the screen shows, on average over these times: 0 for black, 1 for white. */
function painted(times: readonly number[], covered: Scene["covered"]): Float32Array {
  const grey = new Float32Array(ACROSS * DOWN);
  for (const ms of times) {
    const one = new Float32Array(ACROSS * DOWN).fill(1);
    const fill = ([x, y, w, h]: readonly [number, number, number, number], value: number) => {
      const edges = [x, x + w, y, y + h].map((edge) => Math.round((edge + MARGIN) * SCALE));
      const [left = 0, right = 0, top = 0, bottom = 0] = edges;
      for (let row = Math.max(0, top); row < Math.min(DOWN, bottom); row++)
        one.fill(value, row * ACROSS + Math.max(0, left), row * ACROSS + Math.min(ACROSS, right));
    };
    for (const { box, isWhite } of patches(ms)) fill(box, Number(isWhite));
    if (covered) fill(covered, WALL);
    one.forEach((value, at) => {
      grey[at] = (grey[at] ?? 0) + value / times.length;
    });
  }
  return grey;
}

/** The picture that is exposed around `ms`, of a screen of 60 Hz that began at 0. */
function filmed(ms: number, changes: Partial<Scene>, seed = 1): Grey {
  const scene = { ...PLAIN, ...changes };
  const { width, height, exposureMs, covered, black, white, noise } = scene;
  // The code shows the middle of the time for which the screen keeps it.
  const times = [-0.5, -0.25, 0, 0.25, 0.5].map(
    (at) => (Math.floor((ms + at * exposureMs) / REFRESH_MS) + 0.5) * REFRESH_MS,
  );
  const screen = painted(exposureMs > 0 ? times : [ms], covered);
  const between = numbers(seed);
  const place = onScreen(scene);
  const data = new Uint8Array(width * height);
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) {
      let light = 0;
      for (let part = 0; part < 4; part++) {
        const hit = place(column + 0.25 + (part & 1) / 2, row + 0.25 + (part >> 1) / 2);
        const x = Math.floor((hit.x + MARGIN) * SCALE);
        const y = Math.floor((hit.y + MARGIN) * SCALE);
        const isOn = x >= 0 && y >= 0 && x < ACROSS && y < DOWN;
        light += isOn ? (screen[y * ACROSS + x] ?? 0) / 4 : WALL / 4;
      }
      const grain = noise && between(-noise, noise) + between(-noise, noise);
      const grey = black + (white - black) * light + grain;
      data[row * width + column] = Math.min(255, Math.max(0, Math.round(grey)));
    }
  }
  return { width, height, data };
}

/** Which module of the screen is seen at a place of the picture. */
function onScreen(scene: Scene): (column: number, row: number) => { x: number; y: number } {
  const { width, height, turned, back, aside, isMirrored } = scene;
  const focus = width;
  const distance = WIDTH / scene.share;
  const ahead = [(scene.x * distance) / 2, (scene.y * distance * height) / width / 2, distance];
  /** The direction in which a side of the screen points. */
  const turn = (x: number, y: number): number[] => {
    const u = x * Math.cos(aside);
    const v = y * Math.cos(back) + x * Math.sin(aside) * Math.sin(back);
    const w = y * Math.sin(back) - x * Math.sin(aside) * Math.cos(back);
    const [c, s] = [Math.cos(turned), Math.sin(turned)];
    return [u * c - v * s, u * s + v * c, w];
  };
  const [[a = 0, b = 0, c = 0], [d = 0, e = 0, f = 0]] = [turn(isMirrored ? -1 : 1, 0), turn(0, 1)];
  const [m = 0, n = 0, o = 0] = ahead;
  const [p, q, r] = [b * f - c * e, c * d - a * f, a * e - b * d];
  const away = m * p + n * q + o * r;
  return (column, row) => {
    const [x, y] = [column - width / 2, row - height / 2];
    const far = away / (x * p + y * q + focus * r);
    const [u, v, w] = [x * far - m, y * far - n, focus * far - o];
    return { x: u * a + v * b + w * c + WIDTH / 2, y: u * d + v * e + w * f + HEIGHT / 2 };
  };
}

/** A time at which the number is not just changing. */
const steady = (between: (least: number, most: number) => number) =>
  (Math.floor(between(0, 256)) + between(0.2, 0.8)) * PERIOD_MS;

it.each<[string, Partial<Scene>]>([
  ["plain", {}],
  ["small", { share: 0.25 }],
  ["large", { share: 0.88 }],
  ["upside down", { turned: Math.PI }],
  ["on its side", { turned: Math.PI / 2 }],
  ["turned a little", { turned: 0.2 }],
  ["turned half way", { turned: Math.PI / 4 }],
  ["tilted backwards", { back: 0.6 }],
  ["tilted aside", { aside: -0.6 }],
  ["mirrored", { isMirrored: true }],
  ["dim", { black: 8, white: 44, noise: 2 }],
  ["too bright", { black: 140, white: 255 }],
  ["noisy", { noise: 24 }],
  ["exposed for long", { exposureMs: 33 }],
  ["its upper cells covered", { covered: [9, -2, 12, 8] }],
  ["its lower cells covered", { covered: [12, 16, 18, 8] }],
  ["a finder covered", { covered: [-2, -2, 9, 8] }],
  ["part of the strip covered", { covered: [32, 8, 6, 6] }],
])("reads it within 5 ms: %s", (_, scene) => {
  const ms = steady(numbers(3));
  const seen = read(filmed(ms, scene));
  expect(seen).toEqual({ ms: expect.any(Number) });
  expect(Math.abs("ms" in seen ? seen.ms - ms : 99)).toBeLessThan(5);
});

it("finds it in every picture, however these flaws come together", () => {
  let worst = 0;
  for (let seed = 1; seed <= 30; seed++) {
    const between = numbers(seed);
    const ms = steady(between);
    const scene = {
      share: between(0.3, 0.42),
      turned: between(0, 2 * Math.PI),
      back: between(-0.4, 0.4),
      aside: between(-0.4, 0.4),
      isMirrored: between(0, 1) < 0.5,
      black: between(5, 40),
      white: between(90, 250),
      noise: between(0, 8),
      x: between(-0.15, 0.15),
      y: between(-0.1, 0.1),
    };
    const seen = read(filmed(ms, scene, seed));
    expect([seed, seen]).toEqual([seed, { ms: expect.any(Number) }]);
    if ("ms" in seen) worst = Math.max(worst, Math.abs(seen.ms - ms));
  }
  expect(worst).toBeLessThan(3);
});

it("says what to change if it finds none", () => {
  const why = (scene: Partial<Scene>) => read(filmed(100, scene, 3));
  expect(why({ black: 4, white: 7, noise: 2 })).toEqual({ miss: "dark" });
  expect(why({ share: 0.05 })).toEqual({ miss: "nothing" });
  expect(why({ share: 0.8, x: 0.8, y: 0.6 })).toEqual({ miss: "cut_off" });
  expect(why({ covered: [8, -2, 20, 26] })).toEqual({ miss: "unclear" });
  expect(why({ covered: [0, 8, 36, 6] })).toEqual({ miss: "unclear" });
});

it("reads no time while the number changes, rather than a wrong one", () => {
  for (let ms = -40; ms <= 40; ms += 8) {
    const at = 7 * PERIOD_MS + ms;
    const seen = read(filmed(at, { exposureMs: 20 }));
    if ("ms" in seen) expect(Math.abs(seen.ms - at)).toBeLessThan(5);
    else expect(["between", "unclear"]).toContain(seen.miss);
  }
});

it("reads no time where a screen shows some of the old number and some of the new edge", () => {
  const [before, after] = [filmed(7 * PERIOD_MS - 8, {}), filmed(7 * PERIOD_MS + 8, {})];
  const rows = 110 * before.width;
  const data = Uint8Array.from(before.data, (old, at) => (at < rows ? old : (after.data[at] ?? 0)));
  expect(read({ ...before, data })).toEqual({ miss: "between" });
});

it("reads no time where there is none", () => {
  const between = numbers(7);
  for (let n = 0; n < 20; n++) {
    const data = Uint8Array.from({ length: 320 * 180 }, () => between(0, 256));
    expect(read({ width: 320, height: 180, data })).not.toHaveProperty("ms");
  }
});

it("repeats after a minute, so that any delay of seconds is told apart", () => {
  expect(REPEATS_MS).toBe(65_536);
  const seen = read(filmed(REPEATS_MS + 300, {}));
  expect("ms" in seen && Math.abs(seen.ms - 300)).toBeLessThan(5);
});
