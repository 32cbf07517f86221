/** What this page commands, in the robot's own speeds. */

import type { State } from "../state";
import { STANDSTILL, type Twist } from "./motion";

/**
 * Scaled as the server does it: by *Slow*, by the host's limit for guests, and by the share that
 * the server reports. That report is late, so what the page knows itself is applied at once.
 */
export function commanded(state: State): Twist {
  const robot = state.hello.peek()?.robot;
  if (!robot || !state.mayMove.peek()) return STANDSTILL;
  const { linear, angular, lateral = 0 } = state.motion.peek();
  // Ahead and sideways are one vector: a diagonal is no faster than either.
  const length = Math.max(1, Math.hypot(linear, lateral));
  const pace = paceOf(state, robot.slow_fraction);
  const most = state.isHost.peek() ? 1 : (state.room.peek()?.host_settings.max_fraction ?? 1);
  const largest = pace * Math.max(Math.hypot(linear, lateral) / length, Math.abs(angular));
  // The server's share includes the host's limit.
  const allowed = largest > most ? most / largest : 1;
  const share = pace * Math.min(allowed, state.driveShare.peek());
  return {
    linearMps: (linear / length) * share * robot.max_linear_mps,
    angularRps: angular * share * robot.max_angular_rps,
    lateralMps: (lateral / length) * share * (robot.max_lateral_mps ?? 0),
  };
}

/** The share for slow or full speed; a step is slow at any speed. */
function paceOf(state: State, slow: number): number {
  const { speed, way } = state.preferences.peek();
  const isStep = (way === "step" || way === "scan") && state.held.peek().size > 0;
  return speed === "slow" || isStep ? slow : 1;
}
