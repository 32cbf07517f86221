import { describe, expect, it } from "vitest";
import { halfHeightDeg, meshOf, product, type Screen } from "./mesh";

const DEGREES = 180 / Math.PI;
const screen: Screen = { acrossDeg: 80, aspect: 16 / 9, distanceM: 2, isCurved: false };

/** The vertices of a mesh. */
function vertices(of: Screen) {
  const mesh = meshOf(of);
  return Array.from({ length: mesh.length / 5 }, (_, i) => {
    const [x = 0, y = 0, z = 0, u = 0, v = 0] = mesh.subarray(5 * i);
    return { x, y, z, u, v };
  });
}

describe.each([false, true])("a screen, curved: %s", (isCurved) => {
  const shape = { ...screen, isCurved };

  it("shows each spot where a pinhole camera has seen it", () => {
    const focal = 0.5 / Math.tan(40 / DEGREES);
    for (const { x, y, z, u, v } of vertices(shape)) {
      expect(x / -z).toBeCloseTo((u - 0.5) / focal, 5);
      expect(y / -z).toBeCloseTo((0.5 - v) / focal / shape.aspect, 5);
    }
  });

  it("spans its whole width and height", () => {
    const all = vertices(shape);
    expect(Math.min(...all.map(({ u }) => u))).toBeCloseTo(0);
    expect(Math.max(...all.map(({ u }) => u))).toBeCloseTo(1);
    expect(new Set(all.map(({ v }) => v))).toEqual(new Set([0, 1]));
  });

  it("is at its distance", () => {
    for (const { x, z } of vertices(shape)) {
      expect(isCurved ? Math.hypot(x, z) : -z).toBeCloseTo(2, 5);
    }
  });
});

it("turns a screen to where it is to stand, facing the head", () => {
  const all = vertices({ ...screen, yawDeg: 60, pitchDeg: -20 });
  const mean = (of: (one: (typeof all)[number]) => number) =>
    all.reduce((sum, one) => sum + of(one), 0) / all.length;
  const [x, y, z] = [mean((one) => one.x), mean((one) => one.y), mean((one) => one.z)];
  expect(Math.atan2(x, -z) * DEGREES).toBeCloseTo(60, 3);
  expect(Math.atan2(y, Math.hypot(x, z)) * DEGREES).toBeCloseTo(-20, 3);
  expect(Math.hypot(x, y, z)).toBeCloseTo(2, 5);
});

it("shows a picture that sees more than people do no wider than they can look", () => {
  const all = vertices({ ...screen, acrossDeg: 170, isCurved: true });
  const aside = Math.max(...all.map(({ x, z }) => Math.atan2(x, -z) * DEGREES));
  expect(aside).toBeCloseTo(65, 3);
  expect(Math.max(...all.map(({ u }) => u))).toBeCloseTo(1);
});

it("knows how far up a screen reaches", () => {
  const top = Math.max(...vertices(screen).map(({ y, z }) => Math.atan2(y, -z) * DEGREES));
  expect(halfHeightDeg(screen)).toBeCloseTo(top, 3);
});

it("multiplies matrices in WebGL's order", () => {
  const move = Float32Array.from([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]);
  const double = Float32Array.from([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]);
  expect([...product(double, move).slice(12)]).toEqual([10, 12, 14, 1]);
  expect([...product(move, double).slice(12)]).toEqual([5, 6, 7, 1]);
});
