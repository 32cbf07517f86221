/** What this page commands, in the robot's own speeds. */

import type { State } from "../state";
import { STANDSTILL, type Twist } from "./motion";

/**
 * As the server scales it: by *Slow*, for guests by what the host allows, and by what else it says
 * that it does. It says so a while later, so that what the page knows by itself comes first.
 */
export function commanded(state: State): Twist {
  const robot = state.hello.peek()?.robot;
  if (!robot || !state.mayMove.peek()) return STANDSTILL;
  const { linear, angular } = state.motion.peek();
  const pace = paceOf(state, robot.slow_fraction);
  const most = state.isHost.peek() ? 1 : (state.room.peek()?.host_settings.max_fraction ?? 1);
  const largest = pace * Math.max(Math.abs(linear), Math.abs(angular));
  // The host's limit is in the server's share, too.
  const allowed = largest > most ? most / largest : 1;
  const share = pace * Math.min(allowed, state.driveShare.peek());
  return {
    linearMps: linear * share * robot.max_linear_mps,
    angularRps: angular * share * robot.max_angular_rps,
  };
}

/** Slow, or full; a step is slow at any speed. */
function paceOf(state: State, slow: number): number {
  const { speed, way } = state.preferences.peek();
  const isStep = (way === "step" || way === "scan") && state.held.peek().size > 0;
  return speed === "slow" || isStep ? slow : 1;
}
