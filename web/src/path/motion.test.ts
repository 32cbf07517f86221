import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
import { along, moved, ramped, STANDSTILL, START } from "./motion";

describe("a robot that moves", () => {
  it("goes straight ahead, and turns on the spot", () => {
    expect(moved(START, { linearMps: 0.5, angularRps: 0 }, 2)).toEqual({
      aheadM: 1,
      leftM: 0,
      headingRad: 0,
    });
    const turned = moved(START, { linearMps: 0, angularRps: 1 }, 2);
    expect(turned).toEqual({ aheadM: 0, leftM: 0, headingRad: 2 });
  });

  it("is as far ahead as to the left after a quarter circle", () => {
    const radiusM = 0.8;
    const there = along(START, (radiusM * Math.PI) / 2, Math.PI / 2);
    expect(there.aheadM).toBeCloseTo(radiusM, 9);
    expect(there.leftM).toBeCloseTo(radiusM, 9);
  });

  it("arrives at the same place in one step and in many", () => {
    const next = numbers(4);
    for (let n = 0; n < 200; n++) {
      const twist = { linearMps: next(-1, 1), angularRps: next(-2, 2) };
      const forS = next(0.1, 3);
      let pose = START;
      for (let step = 0; step < 10; step++) pose = moved(pose, twist, forS / 10);
      const once = moved(START, twist, forS);
      expect(pose.aheadM).toBeCloseTo(once.aheadM, 9);
      expect(pose.leftM).toBeCloseTo(once.leftM, 9);
      expect(pose.headingRad).toBeCloseTo(once.headingRad, 9);
    }
  });

  it("moves to the mirrored place when it turns the other way", () => {
    const left = moved(START, { linearMps: 0.6, angularRps: 1.2 }, 1);
    const right = moved(START, { linearMps: 0.6, angularRps: -1.2 }, 1);
    expect(right.aheadM).toBeCloseTo(left.aheadM, 12);
    expect(right.leftM).toBeCloseTo(-left.leftM, 12);
  });
});

describe("its speed", () => {
  const ramp = { accelerationMps2: 1.5, accelerationRps2: 6 };
  const full = { linearMps: 0.6, angularRps: 0 };

  it("rises by its acceleration, up to the commanded speed", () => {
    expect(ramped(STANDSTILL, full, 0.2, ramp).linearMps).toBeCloseTo(0.3);
    expect(ramped(STANDSTILL, full, 1, ramp).linearMps).toBe(0.6);
    expect(ramped(full, { linearMps: 0.2, angularRps: 0 }, 0.001, ramp).linearMps).toBeCloseTo(0.2);
  });

  it("falls at once, and then rises the other way", () => {
    expect(ramped(full, STANDSTILL, 0.02, ramp)).toEqual(STANDSTILL);
    const back = { linearMps: -0.6, angularRps: 0 };
    expect(ramped(full, back, 0.02, ramp).linearMps).toBeCloseTo(-0.03);
  });

  it("comes as near to the commanded speed in many steps as in one", () => {
    let speed = STANDSTILL;
    for (let n = 0; n < 20; n++) speed = ramped(speed, full, 0.01, ramp);
    expect(speed.linearMps).toBeCloseTo(0.3, 9);
  });
});
