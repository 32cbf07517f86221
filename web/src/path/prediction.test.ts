import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
import { twist } from "../testing/twist";
import { arcOf, pathData } from "./arc";
import type { Camera } from "./camera";
import type { Twist } from "./motion";
import { History, type Prediction, predict } from "./prediction";

const RAMP = { accelerationMps2: 1.5, accelerationRps2: 6 };
const BRAKING_MPS2 = 2;
const DELAYS = { pictureMs: 200, commandMs: 100 };
const CAMERA: Camera = { heightM: 0.3, tiltDeg: 30, fovDeg: 75, axisRow: 0.5 };
const FRAME_MS = 20;

/** The prediction after this was held for a time. */
function held(
  wanted: Twist,
  forMs: number,
  history = new History(),
  fromMs = 0,
): Prediction | null {
  for (let atMs = fromMs; atMs <= fromMs + forMs; atMs += FRAME_MS)
    history.note(atMs, wanted, RAMP);
  return predict(history, fromMs + forMs, DELAYS, BRAKING_MPS2);
}

function made(prediction: Prediction | null): Prediction {
  if (!prediction) throw new Error("nothing is predicted");
  return prediction;
}

describe("where the robot will be", () => {
  it("is as far as it drives in both delays, and it stops a braking distance further", () => {
    const { arrival, stand } = made(held(twist(0.6, 0), 2000));
    expect(arrival.aheadM).toBeCloseTo(0.6 * 0.3, 6);
    expect(arrival.leftM).toBe(0);
    expect(stand.aheadM).toBeCloseTo(0.6 * 0.3 + 0.6 ** 2 / (2 * BRAKING_MPS2), 6);
  });

  it("is its old place at first, since it has only begun", () => {
    const early = made(held(twist(0.6, 0), 100)).arrival.aheadM;
    const late = made(held(twist(0.6, 0), 2000)).arrival.aheadM;
    expect(early).toBeGreaterThan(0);
    expect(early).toBeLessThan(late / 10);
  });

  it("is its old place while it stands, or turns on the spot", () => {
    expect(held(twist(0, 0), 1000)).toBeNull();
    expect(held(twist(0, 1.5), 1000)).toBeNull();
    expect(predict(new History(), 0, DELAYS, BRAKING_MPS2)).toBeNull();
  });

  it("stops changing within both delays after the release", () => {
    const history = new History();
    held(twist(0.6, 0), 1000, history);
    const just = made(held(twist(0, 0), 100, history, 1020));
    expect(just.onwards).toEqual([]);
    expect(just.stand).toBe(just.arrival);
    expect(just.arrival.aheadM).toBeCloseTo(0.6 * 0.2, 6);
    expect(held(twist(0, 0), 320, history, 1140)).toBeNull();
  });

  it("is behind the robot when it drives back", () => {
    const { arrival, stand } = made(held(twist(-0.6, 0.5), 1000));
    expect(arrival.aheadM).toBeLessThan(0);
    expect(stand.aheadM).toBeLessThan(arrival.aheadM);
  });

  it("is beside the robot when it moves sideways, and it stops a braking distance further", () => {
    const { arrival, stand, onwards } = made(held(twist(0, 0, -0.6), 2000));
    expect(arrival).toMatchObject({ aheadM: 0, headingRad: 0 });
    expect(arrival.leftM).toBeCloseTo(-0.6 * 0.3, 6);
    expect(stand.leftM).toBeCloseTo(-0.6 * 0.3 - 0.6 ** 2 / (2 * BRAKING_MPS2), 6);
    expect((onwards.at(-1)?.leftM ?? 0) - arrival.leftM).toBeCloseTo(-2, 6);
  });

  it("includes stopping on the arc on which it drives", () => {
    const radiusM = 0.5;
    const { arrival, stand } = made(held(twist(0.6, 1.2), 2000));
    for (const pose of [arrival, stand]) {
      const fromCentre = Math.hypot(pose.aheadM, pose.leftM - radiusM);
      expect(fromCentre).toBeCloseTo(radiusM, 6);
    }
    expect(stand.headingRad).toBeGreaterThan(arrival.headingRad);
  });

  it("has a lane two metres long, at every speed", () => {
    for (const linearMps of [0.1, 0.6]) {
      const { arrival, onwards } = made(held(twist(linearMps, 0), 2000));
      expect((onwards.at(-1)?.aheadM ?? 0) - arrival.aheadM).toBeCloseTo(2, 6);
    }
  });

  it("turns at most by a right angle from there", () => {
    const { arrival, onwards } = made(held(twist(0.1, 3), 2000));
    const last = onwards.at(-1);
    expect((last?.headingRad ?? 0) - arrival.headingRad).toBeCloseTo(Math.PI / 2, 6);
  });

  it("is the same at every moment of steady driving", () => {
    const steady = twist(0.6, 0.8, 0.2);
    const history = new History();
    held(steady, 2000, history);
    const written = (nowMs: number) => {
      history.note(nowMs, steady, RAMP);
      const arc = arcOf(made(predict(history, nowMs, DELAYS, BRAKING_MPS2)), CAMERA, 4 / 3, 0.3);
      return [...(arc?.lanes ?? []), arc?.arrival ?? [], arc?.stand ?? []].map(pathData);
    };
    const first = written(2033);
    expect(first[0]).not.toBe("");
    for (const nowMs of [2065.3, 2101, 2117.9, 2500]) expect(written(nowMs)).toEqual(first);
  });

  it("does not remember a previous turn", () => {
    const history = new History();
    held(twist(0.6, 0), 1000, history);
    history.clear();
    expect(predict(history, 1000, DELAYS, BRAKING_MPS2)).toBeNull();
    held(twist(0.6, 0), 1000, history, 20_000);
    expect(held(twist(0.6, 0), 0, history, 40_000)).toBeNull();
  });
});

describe("its lines in the picture", () => {
  const straight = made(held(twist(0.6, 0), 2000));

  it("are mirror images while it drives straight ahead", () => {
    const arc = arcOf(straight, CAMERA, 4 / 3, 0.3);
    const [left = [], right = []] = arc?.lanes ?? [];
    expect(left.length).toBeGreaterThan(5);
    left.forEach((spot, at) => {
      expect(spot.x + (right[at]?.x ?? 0)).toBeCloseTo(1, 9);
      expect(spot.y).toBeCloseTo(right[at]?.y ?? 0, 9);
    });
    for (const tick of [arc?.arrival ?? [], arc?.stand ?? []]) {
      expect(tick).toHaveLength(2);
      expect(tick[0]?.y).toBeCloseTo(tick[1]?.y ?? 0, 9);
    }
  });

  it("lead up the picture, with the stop beyond the command's arrival", () => {
    const next = numbers(5);
    for (let n = 0; n < 100; n++) {
      const linearMps = next(0.1, 1);
      const speed = twist(linearMps, linearMps * next(-0.4, 0.4));
      const arc = arcOf(made(held(speed, 1500)), CAMERA, 4 / 3, 0.3);
      if (!arc) continue;
      for (const lane of arc.lanes) {
        lane.slice(1).forEach((spot, at) => {
          expect(spot.y).toBeLessThan(lane[at]?.y ?? 0);
        });
      }
      const rows = (line: { y: number }[]) => line.reduce((sum, one) => sum + one.y, 0);
      expect(rows(arc.stand)).toBeLessThan(rows(arc.arrival));
    }
  });

  it("bend to the side to which it turns", () => {
    const arc = arcOf(made(held(twist(0.6, 1), 2000)), CAMERA, 4 / 3, null);
    const [middle = []] = arc?.lanes ?? [];
    expect(middle.at(-1)?.x).toBeLessThan((middle[0]?.x ?? 0) - 0.1);
  });

  it("are a single one if the robot's width is unknown", () => {
    const arc = arcOf(straight, CAMERA, 4 / 3, null);
    expect(arc?.lanes).toHaveLength(1);
    expect(arc?.stand).toHaveLength(2);
  });

  const above: Camera = { heightM: 10, tiltDeg: 90, fovDeg: 75, axisRow: 0.5 };
  const WIDTH_M = 0.3;

  /** How broad the strip is from edge to edge, in robot's widths, seen from above. */
  function breadthOf(way: Twist): number {
    const arc = arcOf(made(held(way, 2000)), above, 1, WIDTH_M);
    const [left, right] = (arc?.lanes ?? []).map((lane) => lane.at(-1));
    const widest = 2 * above.heightM * Math.tan((above.fovDeg * Math.PI) / 360);
    const apart = Math.hypot((left?.x ?? 0) - (right?.x ?? 0), (left?.y ?? 0) - (right?.y ?? 0));
    return (apart * widest) / WIDTH_M;
  }

  it("are a square's edges apart: as broad ahead as sideways, broader on a diagonal", () => {
    expect(breadthOf(twist(0.6, 0))).toBeCloseTo(1, 6);
    expect(breadthOf(twist(0, 0, 0.6))).toBeCloseTo(1, 6);
    expect(breadthOf(twist(0.4, 0, 0.4))).toBeCloseTo(Math.SQRT2, 6);
    expect(breadthOf(twist(-0.4, 0, 0.4))).toBeCloseTo(Math.SQRT2, 6);
  });

  it("do not cross when it turns back sideways", () => {
    const history = new History();
    held(twist(0.4, 0, 0.4), 1000, history);
    const back = made(held(twist(-0.4, 0, -0.4), 140, history, 1020));
    expect(new Set(back.until.map((pose) => pose.courseRad)).size).toBe(2);
    const [left = [], right = []] = arcOf(back, above, 1, WIDTH_M)?.lanes ?? [];
    left.forEach((spot, at) => {
      expect(spot.x - spot.y).toBeLessThan((right[at]?.x ?? 0) - (right[at]?.y ?? 0));
    });
  });

  it("are drawn for the part of a diagonal that is in view, and for nothing beside it", () => {
    const arc = arcOf(made(held(twist(0.5, 0, 0.3), 2000)), CAMERA, 4 / 3, WIDTH_M);
    expect(arc?.lanes.every((lane) => lane.length > 2)).toBe(true);
    expect(arcOf(made(held(twist(0, 0, 0.6), 2000)), CAMERA, 4 / 3, WIDTH_M)).toBeNull();
  });

  it("are none if the path is out of view", () => {
    const back = made(held(twist(-0.6, 0), 2000));
    expect(arcOf(back, { ...CAMERA, tiltDeg: 0 }, 4 / 3, 0.3)).toBeNull();
  });

  it("are written for a box of 100 by 100", () => {
    const line = [
      { x: 0.5, y: 0.25 },
      { x: 0.123456, y: 1 },
    ];
    expect(pathData(line)).toBe("M50 25L12.35 100");
    expect(pathData(line.slice(1))).toBe("");
  });
});
