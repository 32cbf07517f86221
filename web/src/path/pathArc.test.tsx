// @vitest-environment dom
import { act } from "preact/test-utils";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import type { State } from "../state";
import { draw, undraw } from "../testing/draw";
import { hello, pressedBy, room } from "../testing/messages";
import { testSession as made } from "../testing/session";
import { twist } from "../testing/twist";
import { commanded } from "./commanded";
import { PathArc } from "./PathArc";
import { aspectOf, drivingCamera } from "./view";

const CAMERA = { height_m: 0.3, tilt_deg: 30, fov_deg: 75, axis_row: 0.5 };

let session: Session;
let state: State;
const body = document.body;

/** This page drives a robot whose camera is known, over a link with a delay. */
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["requestAnimationFrame", "cancelAnimationFrame", "performance"] });
  session = made();
  state = session.state;
  const mine = hello();
  state.hello.value = { ...mine, robot: { ...mine.robot, axes: ["pan"], camera: CAMERA } };
  state.room.value = room({ operator: 1 });
  state.link.value = { is: "connected" };
  state.facts.value = { ...state.facts.value, pictureMs: 200, roundTripMs: 160 };
  draw(session, <PathArc />);
});

afterEach(() => {
  undraw();
  // A pending frame also has a real timer, which would fire after the test's teardown.
  vi.advanceTimersByTime(20);
});

function drawn(): boolean {
  return [...body.querySelectorAll("path")].some((one) => one.getAttribute("d"));
}

/** How far down the picture the robot would stop, in hundredths. */
function standsAt(): number {
  const line = body.querySelector(".path-stand")?.getAttribute("d") ?? "";
  return Number(line.split(" ")[1]?.split("L")[0]);
}

function hold(...directions: ("forward" | "back" | "left" | "right")[]): void {
  act(() => push(...directions));
}

/** Holds these directions as the controls do. */
function push(...directions: ("forward" | "back" | "left" | "right")[]): void {
  const share = (one: (typeof directions)[number]) => (directions.includes(one) ? 1 : 0);
  state.held.value = new Set(directions);
  state.motion.value = {
    linear: share("forward") - share("back"),
    angular: share("left") - share("right"),
  };
}

function wait(ms: number): void {
  vi.advanceTimersByTime(ms);
}

describe("the predicted path", () => {
  it("is drawn while this page drives, and removed soon after the release", () => {
    wait(500);
    expect(drawn()).toBe(false);
    hold("forward");
    wait(1000);
    expect(drawn()).toBe(true);
    hold();
    wait(1000);
    expect(drawn()).toBe(false);
    expect(vi.getTimerCount()).toBe(0);
  });

  it("costs nothing while nothing moves", () => {
    expect(vi.getTimerCount()).toBe(0);
  });

  it("ends with the turn", () => {
    hold("forward");
    wait(1000);
    act(() => {
      state.room.value = room({ operator: 2 });
    });
    wait(1000);
    expect(drawn()).toBe(false);
    expect(vi.getTimerCount()).toBe(0);
  });

  it("is removed with its view", () => {
    hold("forward");
    wait(100);
    undraw();
    expect(vi.getTimerCount()).toBe(0);
  });

  it.each([
    ["the picture's age is not known", () => ({ pictureMs: null })],
    ["the picture is old", () => ({ pictureMs: 2000 })],
    ["the link's delay is not known", () => ({ roundTripMs: null })],
  ])("is not drawn while %s", (_, facts) => {
    state.facts.value = { ...state.facts.value, ...facts() };
    hold("forward");
    wait(1000);
    expect(drawn()).toBe(false);
  });

  it("is not drawn while the server holds the robot, and returns afterwards", () => {
    hold("forward");
    wait(1000);
    state.driveShare.value = 0;
    wait(1000);
    expect(drawn()).toBe(false);
    state.driveShare.value = 1;
    wait(1000);
    expect(drawn()).toBe(true);
  });

  it("is shorter while the server slows the robot", () => {
    prefer({ speed: "fast" });
    hold("forward");
    wait(1000);
    const far = standsAt();
    state.driveShare.value = 0.3;
    wait(1000);
    expect(drawn()).toBe(true);
    // Lower in the picture is nearer.
    expect(standsAt()).toBeGreaterThan(far + 1);
  });

  it("is not drawn while the robot turns on the spot", () => {
    hold("left");
    wait(1000);
    expect(drawn()).toBe(false);
  });
});

describe("the camera", () => {
  it("is the driving view's", () => {
    expect(drivingCamera(state)).toEqual({ heightM: 0.3, tiltDeg: 30, fovDeg: 75, axisRow: 0.5 });
    expect(aspectOf(state)).toBeCloseTo(4 / 3);
  });

  it.each([
    ["another is large", () => (state.large.value = 0)],
    ["the picture is off", () => prefer({ picture: false })],
    ["the path is off", () => prefer({ path: false })],
    ["this page has turned it", () => (state.axes.value = { pan: 0.3 })],
    ["it was turned when the turn began", () => begin({ pan: 0.3 })],
    ["nobody knows it", () => know(null)],
    ["it is two, side by side", () => pair()],
    ["the host has drawn the curtain", () => blank()],
  ])("is none while %s", (_, change) => {
    change();
    expect(drivingCamera(state)).toBeNull();
  });

  it("is available again once it was turned back", () => {
    begin({ pan: 0.3 });
    state.axes.value = { pan: 0 };
    expect(drivingCamera(state)).not.toBeNull();
  });

  it("is not turned by the axes of other cameras", () => {
    const now = state.hello.peek();
    if (now) state.hello.value = { ...now, cameras: [{ name: "Arm", axes: ["pan"] }] };
    state.axes.value = { pan: 1 };
    expect(drivingCamera(state)).not.toBeNull();
  });
});

describe("what is commanded", () => {
  it("is in the robot's own speeds", () => {
    prefer({ speed: "fast" });
    push("forward", "left");
    expect(commanded(state)).toEqual(twist(0.6, 1.5));
    push("back");
    expect(commanded(state)).toEqual(twist(-0.6, 0));
    state.motion.value = { linear: 0.5, angular: -0.25 };
    expect(commanded(state)).toEqual(twist(0.3, -0.375));
  });

  it("is no faster on a diagonal than ahead, and never sideways where the robot cannot", () => {
    prefer({ speed: "fast" });
    state.motion.value = { linear: 1, angular: 0, lateral: -1 };
    const aslant = 0.6 * Math.SQRT1_2;
    expect(commanded(state).lateralMps).toBeCloseTo(0);
    const now = state.hello.peek();
    if (now) state.hello.value = { ...now, robot: { ...now.robot, max_lateral_mps: 0.6 } };
    expect(commanded(state).linearMps).toBeCloseTo(aslant);
    expect(commanded(state).lateralMps).toBeCloseTo(-aslant);
    state.driveShare.value = 0.5;
    expect(commanded(state).lateralMps).toBeCloseTo(-aslant / 2);
  });

  it("is slower at slow speed, and with the host's limit for guests", () => {
    push("forward");
    expect(commanded(state).linearMps).toBeCloseTo(0.6 * 0.3);
    prefer({ speed: "fast" });
    const now = room({ operator: 1 });
    state.room.value = { ...now, host_settings: { ...now.host_settings, max_fraction: 0.5 } };
    expect(commanded(state).linearMps).toBeCloseTo(0.3);
    prefer({ speed: "slow" });
    expect(commanded(state).linearMps).toBeCloseTo(0.6 * 0.3);
  });

  it("is proportional to a stick's deflection", () => {
    prefer({ speed: "fast" });
    state.motion.value = { linear: 0.5, angular: -0.25 };
    expect(commanded(state)).toEqual(twist(0.3, -0.375));
  });

  it("is slow for a step at any speed", () => {
    prefer({ speed: "fast", way: "step" });
    push("forward");
    expect(commanded(state).linearMps).toBeCloseTo(0.6 * 0.3);
  });

  it("follows the server's share, without slowing twice for one reason", () => {
    prefer({ speed: "fast" });
    push("forward");
    state.driveShare.value = 0.25;
    expect(commanded(state).linearMps).toBeCloseTo(0.15);
    const now = room({ operator: 1 });
    state.room.value = { ...now, host_settings: { ...now.host_settings, max_fraction: 0.5 } };
    state.driveShare.value = 0.5;
    expect(commanded(state).linearMps).toBeCloseTo(0.3);
    state.driveShare.value = 0;
    expect(commanded(state)).toEqual(twist(0, 0));
  });

  it("is nothing while a stop is in force", () => {
    push("forward");
    state.room.value = room({
      operator: 1,
      stop: pressedBy("Ada"),
    });
    expect(commanded(state)).toEqual(twist(0, 0));
  });
});

function prefer(change: object): void {
  state.preferences.value = { ...state.preferences.value, ...change };
}

function begin(axes: Record<string, number>): void {
  const now = room({ operator: 1 });
  state.room.value = { ...now, turn: { ...now.turn, axes } };
}

function know(camera: typeof CAMERA | null): void {
  const now = state.hello.peek();
  if (now) state.hello.value = { ...now, robot: { ...now.robot, camera } };
}

function pair(): void {
  const now = state.hello.peek();
  if (now) state.hello.value = { ...now, robot: { ...now.robot, camera_stereo: true } };
}

function blank(): void {
  const now = room({ operator: 1 });
  state.room.value = { ...now, host_settings: { ...now.host_settings, blanked: true } };
}
