import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
import { type Camera, project } from "./camera";
import { configurationOf, type Seen, solve } from "./solve";

const ASPECT = 4 / 3;

function seen(camera: Camera, distanceM: number): Seen {
  return { distanceM, row: project(camera, ASPECT, { aheadM: distanceM, leftM: 0 })?.y ?? 9 };
}

describe("a camera from two points on the floor", () => {
  it("is the one that sees them there", () => {
    const next = numbers(6);
    let found = 0;
    for (let n = 0; n < 1000; n++) {
      const camera = {
        heightM: next(0.1, 1.5),
        tiltDeg: next(-5, 50),
        fovDeg: next(45, 90),
        axisRow: 0.5,
      };
      const near = seen(camera, next(0.3, 1));
      const far = seen(camera, next(1.2, 4));
      const isInPicture = near.row <= 1 && far.row >= 0 && near.row - far.row >= 0.02;
      if (!isInPicture) continue;
      found++;
      const solution = solve(camera.heightM, near, far, ASPECT);
      if (solution.is !== "found") throw new Error(`${solution.why} for ${JSON.stringify(camera)}`);
      expect(solution.camera.tiltDeg).toBeCloseTo(camera.tiltDeg, 5);
      expect(solution.camera.fovDeg).toBeCloseTo(camera.fovDeg, 5);
    }
    expect(found).toBeGreaterThan(300);
  });

  it("is nearly that one if a finger was some pixels off", () => {
    const camera = { heightM: 0.35, tiltDeg: 15, fovDeg: 70, axisRow: 0.5 };
    const next = numbers(7);
    for (let n = 0; n < 200; n++) {
      const off = () => next(-2 / 480, 2 / 480);
      const near = seen(camera, 0.5);
      const far = seen(camera, 1.5);
      const solution = solve(
        camera.heightM,
        { ...near, row: near.row + off() },
        { ...far, row: far.row + off() },
        ASPECT,
      );
      if (solution.is !== "found") throw new Error(solution.why);
      expect(Math.abs(solution.camera.tiltDeg - camera.tiltDeg)).toBeLessThan(1.5);
      expect(Math.abs(solution.camera.fovDeg - camera.fovDeg)).toBeLessThan(3);
      // What matters: the floor between and beyond the points is in the same place.
      for (const distanceM of [0.6, 1, 2]) {
        const drawn = seen(solution.camera, distanceM).row;
        expect(Math.abs(drawn - seen(camera, distanceM).row)).toBeLessThan(0.01);
      }
    }
  });

  const near = { distanceM: 0.5, row: 0.9 };
  const far = { distanceM: 1.5, row: 0.5 };

  it.each([
    ["path.bad_height", 0, near, far],
    ["path.bad_height", Number.NaN, near, far],
    ["path.bad_height", 9, near, far],
    ["path.bad_distances", 0.3, { ...near, distanceM: 0 }, far],
    ["path.bad_distances", 0.3, near, { ...far, distanceM: 0.5 }],
    ["path.bad_distances", 0.3, near, { ...far, distanceM: Number.NaN }],
    ["path.bad_points", 0.3, near, { ...far, row: 0.9 }],
    ["path.bad_points", 0.3, far, near, true],
    ["path.bad_points", 0.3, near, { ...far, row: Number.NaN }],
    // So far apart that the field of view would be less than 10 degrees.
    ["path.no_camera", 0.02, { distanceM: 2, row: 1 }, { distanceM: 2.1, row: 0 }],
    // So high that the camera would look at the ceiling.
    ["path.no_camera", 2, { distanceM: 0.3, row: 0.1 }, { distanceM: 3, row: 0.01 }],
  ] as const)("is none, with a sentence: %s", (why, heightM, one, other, isSwapped?: boolean) => {
    const distances = isSwapped
      ? ([
          { ...one, distanceM: other.distanceM },
          { ...other, distanceM: one.distanceM },
        ] as const)
      : ([one, other] as const);
    expect(solve(heightM, ...distances, ASPECT)).toEqual({ is: "impossible", why });
  });

  it("is valid in the configuration, whatever was clicked", () => {
    const next = numbers(8);
    for (let n = 0; n < 2000; n++) {
      const one = { distanceM: next(-1, 5), row: next(-0.2, 1.2) };
      const other = { distanceM: next(-1, 9), row: next(-0.2, 1.2) };
      const solution = solve(next(-0.5, 6), one, other, ASPECT);
      if (solution.is !== "found") continue;
      const { heightM, tiltDeg, fovDeg } = solution.camera;
      expect(heightM).toBeGreaterThanOrEqual(0.02);
      expect(heightM).toBeLessThanOrEqual(5);
      expect(tiltDeg).toBeGreaterThanOrEqual(-30);
      expect(tiltDeg).toBeLessThanOrEqual(80);
      expect(fovDeg).toBeGreaterThanOrEqual(10);
      expect(fovDeg).toBeLessThanOrEqual(170);
    }
  });
});

it("is written in the configuration's format", () => {
  const camera = { heightM: 0.35, tiltDeg: -0.02, fovDeg: 71.26, axisRow: 0.5 };
  expect(configurationOf(camera)).toBe(
    "[video]\ncamera_height_m = 0.350\ncamera_tilt_deg = 0.0\ncamera_fov_deg = 71.3",
  );
});
