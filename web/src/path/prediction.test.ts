import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
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
function held(twist: Twist, forMs: number, history = new History(), fromMs = 0): Prediction | null {
  for (let atMs = fromMs; atMs <= fromMs + forMs; atMs += FRAME_MS) history.note(atMs, twist, RAMP);
  return predict(history, fromMs + forMs, DELAYS, BRAKING_MPS2);
}

function made(prediction: Prediction | null): Prediction {
  if (!prediction) throw new Error("nothing is predicted");
  return prediction;
}

describe("where the robot will be", () => {
  it("is as far as it drives in both delays, and it stops a braking distance further", () => {
    const { arrival, stand } = made(held({ linearMps: 0.6, angularRps: 0 }, 2000));
    expect(arrival.aheadM).toBeCloseTo(0.6 * 0.3, 6);
    expect(arrival.leftM).toBe(0);
    expect(stand.aheadM).toBeCloseTo(0.6 * 0.3 + 0.6 ** 2 / (2 * BRAKING_MPS2), 6);
  });

  it("is its old place at first, since it has only begun", () => {
    const early = made(held({ linearMps: 0.6, angularRps: 0 }, 100)).arrival.aheadM;
    const late = made(held({ linearMps: 0.6, angularRps: 0 }, 2000)).arrival.aheadM;
    expect(early).toBeGreaterThan(0);
    expect(early).toBeLessThan(late / 10);
  });

  it("is its old place while it stands, or turns on the spot", () => {
    expect(held({ linearMps: 0, angularRps: 0 }, 1000)).toBeNull();
    expect(held({ linearMps: 0, angularRps: 1.5 }, 1000)).toBeNull();
    expect(predict(new History(), 0, DELAYS, BRAKING_MPS2)).toBeNull();
  });

  it("stops changing within both delays after the release", () => {
    const history = new History();
    held({ linearMps: 0.6, angularRps: 0 }, 1000, history);
    const just = made(held({ linearMps: 0, angularRps: 0 }, 100, history, 1020));
    expect(just.onwards).toEqual([]);
    expect(just.stand).toBe(just.arrival);
    expect(just.arrival.aheadM).toBeCloseTo(0.6 * 0.2, 6);
    expect(held({ linearMps: 0, angularRps: 0 }, 320, history, 1140)).toBeNull();
  });

  it("is behind the robot when it drives back", () => {
    const { arrival, stand } = made(held({ linearMps: -0.6, angularRps: 0.5 }, 1000));
    expect(arrival.aheadM).toBeLessThan(0);
    expect(stand.aheadM).toBeLessThan(arrival.aheadM);
  });

  it("includes stopping on the arc on which it drives", () => {
    const radiusM = 0.5;
    const { arrival, stand } = made(held({ linearMps: 0.6, angularRps: 1.2 }, 2000));
    for (const pose of [arrival, stand]) {
      const fromCentre = Math.hypot(pose.aheadM, pose.leftM - radiusM);
      expect(fromCentre).toBeCloseTo(radiusM, 6);
    }
    expect(stand.headingRad).toBeGreaterThan(arrival.headingRad);
  });

  it("has a lane two metres long, at every speed", () => {
    for (const linearMps of [0.1, 0.6]) {
      const { arrival, onwards } = made(held({ linearMps, angularRps: 0 }, 2000));
      expect((onwards.at(-1)?.aheadM ?? 0) - arrival.aheadM).toBeCloseTo(2, 6);
    }
  });

  it("turns at most by a right angle from there", () => {
    const { arrival, onwards } = made(held({ linearMps: 0.1, angularRps: 3 }, 2000));
    const last = onwards.at(-1);
    expect((last?.headingRad ?? 0) - arrival.headingRad).toBeCloseTo(Math.PI / 2, 6);
  });

  it("is the same at every moment of steady driving", () => {
    const twist = { linearMps: 0.6, angularRps: 0.8 };
    const history = new History();
    held(twist, 2000, history);
    const written = (nowMs: number) => {
      history.note(nowMs, twist, RAMP);
      const arc = arcOf(made(predict(history, nowMs, DELAYS, BRAKING_MPS2)), CAMERA, 4 / 3, 0.3);
      return [...(arc?.lanes ?? []), arc?.arrival ?? [], arc?.stand ?? []].map(pathData);
    };
    const first = written(2033);
    expect(first[0]).not.toBe("");
    for (const nowMs of [2065.3, 2101, 2117.9, 2500]) expect(written(nowMs)).toEqual(first);
  });

  it("does not remember a previous turn", () => {
    const history = new History();
    held({ linearMps: 0.6, angularRps: 0 }, 1000, history);
    history.clear();
    expect(predict(history, 1000, DELAYS, BRAKING_MPS2)).toBeNull();
    held({ linearMps: 0.6, angularRps: 0 }, 1000, history, 20_000);
    expect(held({ linearMps: 0.6, angularRps: 0 }, 0, history, 40_000)).toBeNull();
  });
});

describe("its lines in the picture", () => {
  const straight = made(held({ linearMps: 0.6, angularRps: 0 }, 2000));

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
      const speed = { linearMps, angularRps: linearMps * next(-0.4, 0.4) };
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
    const arc = arcOf(made(held({ linearMps: 0.6, angularRps: 1 }, 2000)), CAMERA, 4 / 3, null);
    const [middle = []] = arc?.lanes ?? [];
    expect(middle.at(-1)?.x).toBeLessThan((middle[0]?.x ?? 0) - 0.1);
  });

  it("are a single one if the robot's width is unknown", () => {
    const arc = arcOf(straight, CAMERA, 4 / 3, null);
    expect(arc?.lanes).toHaveLength(1);
    expect(arc?.stand).toHaveLength(2);
  });

  it("are none if the path is out of view", () => {
    const back = made(held({ linearMps: -0.6, angularRps: 0 }, 2000));
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
