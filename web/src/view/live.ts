/** Whether the picture shows what the robot sees now. Pure. */

import type { State } from "../state";

/** A picture older than this no longer shows what the robot sees. */
export const STALE_MS = 1500;

/** Whether the newest picture is too old to be live. */
export function isStale({ facts }: Pick<State, "facts">): boolean {
  return (facts.value.pictureMs ?? 0) > STALE_MS;
}

/** Whether the large picture is live, be it the driving view or another camera. */
export function isLive(state: State): boolean {
  const { isConnected, isSilent, large, staleCameras } = state;
  if (!isConnected.value || isSilent.value) return false;
  return large.value === null ? !isStale(state) : !staleCameras.value.has(large.value);
}
