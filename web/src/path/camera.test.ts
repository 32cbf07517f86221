import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
import { type Camera, NEAR_M, project, projectLine, radians } from "./camera";

const ASPECT = 4 / 3;

function anyCamera(next: (least: number, most: number) => number): Camera {
  return {
    heightM: next(0.05, 2),
    tiltDeg: next(-10, 60),
    fovDeg: next(40, 110),
    axisRow: next(0.4, 0.6),
  };
}

describe("a place on the floor in the picture", () => {
  it("is where the angles of its line of sight put it", () => {
    const next = numbers(1);
    for (let n = 0; n < 500; n++) {
      const camera = anyCamera(next);
      const aheadM = next(0.1, 20);
      const belowRad = Math.atan2(camera.heightM, aheadM) - radians(camera.tiltDeg);
      if (Math.abs(belowRad) > 1.4) continue;
      // The picture's half width is the tangent of half the field of view; its pixels are square.
      const perWidth = 2 * Math.tan(radians(camera.fovDeg) / 2);
      const spot = project(camera, ASPECT, { aheadM, leftM: 0 });
      expect(spot?.x).toBeCloseTo(0.5, 9);
      expect(spot?.y).toBeCloseTo(camera.axisRow + (Math.tan(belowRad) / perWidth) * ASPECT, 6);
    }
  });

  it("mirrors from side to side", () => {
    const next = numbers(2);
    for (let n = 0; n < 200; n++) {
      const camera = anyCamera(next);
      const [aheadM, leftM] = [next(0.5, 20), next(0, 3)];
      const left = project(camera, ASPECT, { aheadM, leftM });
      const right = project(camera, ASPECT, { aheadM, leftM: -leftM });
      if (!left || !right) continue;
      expect(left.x + right.x).toBeCloseTo(1, 9);
      expect(left.y).toBe(right.y);
      expect(left.x).toBeLessThanOrEqual(0.5);
    }
  });

  it("rises towards the horizon with its distance, and never reaches it", () => {
    const next = numbers(3);
    for (let n = 0; n < 200; n++) {
      const camera = anyCamera(next);
      const horizon = project(camera, ASPECT, { aheadM: 1e9, leftM: 0 })?.y ?? Number.NaN;
      let before = Number.POSITIVE_INFINITY;
      for (let aheadM = 0.2; aheadM < 200; aheadM *= 1.5) {
        const y = project(camera, ASPECT, { aheadM, leftM: 0 })?.y;
        if (y === undefined) continue;
        expect(y).toBeLessThan(before);
        expect(y).toBeGreaterThan(horizon);
        before = y;
      }
      expect(before - horizon).toBeLessThan(0.05);
    }
  });

  it("has the width that the field of view gives at its distance", () => {
    const level = { heightM: 0.5, tiltDeg: 0, fovDeg: 90, axisRow: 0.5 };
    expect(project(level, ASPECT, { aheadM: 2, leftM: 2 })?.x).toBeCloseTo(0, 9);
    expect(project(level, ASPECT, { aheadM: 2, leftM: -2 })?.x).toBeCloseTo(1, 9);
  });

  it("is nowhere if it is behind the lens", () => {
    const level = { heightM: 0.5, tiltDeg: 0, fovDeg: 70, axisRow: 0.5 };
    expect(project(level, ASPECT, { aheadM: -1, leftM: 0 })).toBeNull();
    expect(project(level, ASPECT, { aheadM: NEAR_M / 2, leftM: 0 })).toBeNull();
  });
});

describe("a line on the floor", () => {
  const level = { heightM: 0.5, tiltDeg: 0, fovDeg: 70, axisRow: 0.5 };

  it("is cut off at the lens, and keeps what is in front of it", () => {
    const line = [
      { aheadM: -1, leftM: 0.2 },
      { aheadM: 1, leftM: 0.2 },
      { aheadM: 2, leftM: 0.2 },
      { aheadM: -2, leftM: 0.2 },
    ];
    const spots = projectLine(level, ASPECT, line);
    expect(spots).toHaveLength(4);
    expect(spots[0]).toEqual(spots[3]);
    expect(spots[1]).toEqual(project(level, ASPECT, { aheadM: 1, leftM: 0.2 }));
  });

  it("is empty behind the lens", () => {
    const line = [
      { aheadM: -1, leftM: 0 },
      { aheadM: -2, leftM: 0 },
    ];
    expect(projectLine(level, ASPECT, line)).toEqual([]);
    expect(projectLine(level, ASPECT, [])).toEqual([]);
  });
});
