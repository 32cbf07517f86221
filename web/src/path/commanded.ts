/** What this page commands, in the robot's own speeds. */

import type { State } from "../state";
import { STANDSTILL, type Twist } from "./motion";

/** As the server scales it: by *Slow*, and for guests by what the host allows. */
export function commanded(state: State): Twist {
  const robot = state.hello.peek()?.robot;
  if (!robot || !state.mayMove.peek()) return STANDSTILL;
  const { linear, angular } = state.motion.peek();
  const pace = paceOf(state, robot.slow_fraction);
  const most = state.isHost.peek() ? 1 : (state.room.peek()?.house.max_fraction ?? 1);
  const largest = pace * Math.max(Math.abs(linear), Math.abs(angular));
  const share = largest > most ? (pace * most) / largest : pace;
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
