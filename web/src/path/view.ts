/** Whether, and through which camera, the driving view shows the floor ahead. */

import type { State } from "../state";
import type { Camera } from "./camera";

/** An axis moved by less than this counts as centred. */
const CENTRED = 0.02;

/**
 * The camera of the driving view; null while the path cannot be drawn, because the camera is not
 * calibrated, is turned aside or shows a stereo pair, or another picture is large.
 */
export function drivingCamera(state: State): Camera | null {
  const { camera = null, camera_stereo: isPair } = state.hello.value?.robot ?? {};
  const { picture, path } = state.preferences.value;
  const isShown = picture && path && !state.isBlanked.value;
  if (!camera || isPair || !isShown || state.large.value !== null || !isCentred(state)) return null;
  return {
    heightM: camera.height_m,
    tiltDeg: camera.tilt_deg,
    fovDeg: camera.fov_deg,
    axisRow: camera.axis_row,
  };
}

/** The picture's width by its height, which all its sizes share. */
export function aspectOf(state: State): number {
  const [width, height] = (state.hello.value?.sizes[0] ?? "").split("x").map(Number);
  return width && height ? width / height : 4 / 3;
}

/**
 * Whether every axis that may turn the driving view is centred, by where this page has sent it, or
 * else by where it was when the turn began. An axis that nobody has moved is at its start.
 */
export function isCentred(state: State): boolean {
  const others = new Set(state.cameras.value.flatMap((one) => one.axes));
  const first = state.room.value?.turn.axes ?? {};
  return (state.hello.value?.robot.axes ?? [])
    .filter((axis) => !others.has(axis))
    .every((axis) => Math.abs(state.axes.value[axis] ?? first[axis] ?? 0) < CENTRED);
}
