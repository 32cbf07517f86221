import { describe, expect, it } from "vitest";
import { numbers } from "../testing/random";
import { twist } from "../testing/twist";
import { moved, ramped, STANDSTILL, START } from "./motion";

describe("a robot that moves", () => {
  it("goes straight ahead, and turns on the spot", () => {
    expect(moved(START, twist(0.5, 0), 2)).toEqual({
      aheadM: 1,
      leftM: 0,
      headingRad: 0,
      courseRad: 0,
    });
    const turned = moved(START, twist(0, 1), 2);
    expect(turned).toEqual({ ...START, headingRad: 2 });
  });

  it("goes to the left without turning, where its base can", () => {
    const there = moved(START, twist(0, 0, 0.5), 2);
    expect(there).toEqual({ aheadM: 0, leftM: 1, headingRad: 0, courseRad: Math.PI / 2 });
  });

  it("is as far ahead as to the left after a quarter circle", () => {
    const radiusM = 0.8;
    const there = moved(START, twist((radiusM * Math.PI) / 2, Math.PI / 2), 1);
    expect(there.aheadM).toBeCloseTo(radiusM, 9);
    expect(there.leftM).toBeCloseTo(radiusM, 9);
    const sideways = moved(START, twist(0, Math.PI / 2, (radiusM * Math.PI) / 2), 1);
    expect(sideways.aheadM).toBeCloseTo(-radiusM, 9);
    expect(sideways.leftM).toBeCloseTo(radiusM, 9);
  });

  it("arrives at the same place in one step and in many", () => {
    const next = numbers(4);
    for (let n = 0; n < 200; n++) {
      const any = twist(next(-1, 1), next(-2, 2), next(-1, 1));
      const forS = next(0.1, 3);
      let pose = START;
      for (let step = 0; step < 10; step++) pose = moved(pose, any, forS / 10);
      const once = moved(START, any, forS);
      expect(pose.aheadM).toBeCloseTo(once.aheadM, 9);
      expect(pose.leftM).toBeCloseTo(once.leftM, 9);
      expect(pose.headingRad).toBeCloseTo(once.headingRad, 9);
    }
  });

  it("moves to the mirrored place when it turns the other way", () => {
    const left = moved(START, twist(0.6, 1.2), 1);
    const right = moved(START, twist(0.6, -1.2), 1);
    expect(right.aheadM).toBeCloseTo(left.aheadM, 12);
    expect(right.leftM).toBeCloseTo(-left.leftM, 12);
  });
});

describe("its speed", () => {
  const ramp = { accelerationMps2: 1.5, accelerationRps2: 6 };
  const full = twist(0.6, 0);

  it("rises by its acceleration, up to the commanded speed", () => {
    expect(ramped(STANDSTILL, full, 0.2, ramp).linearMps).toBeCloseTo(0.3);
    expect(ramped(STANDSTILL, full, 1, ramp).linearMps).toBe(0.6);
    expect(ramped(full, twist(0.2, 0), 0.001, ramp).linearMps).toBeCloseTo(0.2);
  });

  it("falls at once, and then rises the other way", () => {
    expect(ramped(full, STANDSTILL, 0.02, ramp)).toEqual(STANDSTILL);
    const back = twist(-0.6, 0);
    expect(ramped(full, back, 0.02, ramp).linearMps).toBeCloseTo(-0.03);
  });

  it("keeps what points the new way, and gains from there straight to the commanded speed", () => {
    const sideways = ramped(full, twist(0, 0, 0.6), 0.1, ramp);
    expect(sideways.linearMps).toBe(0);
    expect(sideways.lateralMps).toBeCloseTo(0.15);
    const diagonal = ramped(full, twist(0.3, 0, 0.3), 0.1, ramp);
    expect(diagonal.linearMps).toBeCloseTo(0.3);
    expect(diagonal.lateralMps).toBeCloseTo(0.15);
  });

  it("comes as near to the commanded speed in many steps as in one", () => {
    let speed = STANDSTILL;
    for (let n = 0; n < 20; n++) speed = ramped(speed, full, 0.01, ramp);
    expect(speed.linearMps).toBeCloseTo(0.3, 9);
  });
});
