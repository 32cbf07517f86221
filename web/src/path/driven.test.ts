import { readFileSync } from "node:fs";
import { expect, it } from "vitest";
import { loadPreferences } from "../preferences";
import { createState } from "../state";
import { hello, room } from "../testing/messages";
import { commanded } from "./commanded";
import { History } from "./prediction";

/** Driven by the simulated robot, as the server's own tests check. */
const VECTORS: {
  motions: {
    name: string;
    held: { linear: number; angular: number; lateral: number }[];
    driven: { ahead_m: number; left_m: number; heading_rad: number };
  }[];
} = JSON.parse(readFileSync(new URL("../../../tests/vectors/paths.json", import.meta.url), "utf8"));

const RAMP = { accelerationMps2: 1.5, accelerationRps2: 6 };
const FRAME_MS = 33;
const NEAR_M = 0.1;

it.each(VECTORS.motions)(
  "the path drawn ends where the robot drives: $name",
  ({ held, driven }) => {
    const state = createState(loadPreferences(null));
    const mine = hello();
    state.hello.value = { ...mine, robot: { ...mine.robot, max_lateral_mps: 0.6 } };
    state.room.value = room({ operator: 1 });
    state.link.value = { is: "connected" };
    state.preferences.value = { ...state.preferences.value, speed: "fast" };
    const history = new History();
    for (let atMs = 0; atMs < 1000 * held.length; atMs += FRAME_MS) {
      state.motion.value = held[Math.floor(atMs / 1000)] ?? { linear: 0, angular: 0 };
      history.note(atMs, commanded(state), RAMP);
    }
    const there = history.since(0, 1000 * held.length).at(-1);
    const apartM = Math.hypot(
      (there?.aheadM ?? 0) - driven.ahead_m,
      (there?.leftM ?? 0) - driven.left_m,
    );
    expect(apartM).toBeLessThanOrEqual(NEAR_M);
    expect(Math.abs((there?.headingRad ?? 0) - driven.heading_rad)).toBeLessThan(0.1);
  },
);
