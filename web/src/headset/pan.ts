/** The right stick as the camera's, in place of the keys that move its axes (`axisKeys.ts`). */

import type { Actions } from "../actions";
import { keyedAxes } from "../drive/axisKeys";
import type { State } from "../state";
import type { Hands } from "./controllers";

const HOLDER = "headset-pan";
/** Held like a stick in its middle: it counts as held, and whatever lets go ends it. */
const STILL = { linear: 0, angular: 0 };
/** From one end to the other in two seconds. */
const SHARE_PER_S = 1;

export class Pan {
  #isPushed = false;

  constructor(
    private readonly state: Pick<State, "axes" | "hello">,
    private readonly actions: Pick<Actions, "press" | "deflect" | "release" | "setAxis">,
  ) {}

  /** Moves the axes by what the stick says now, after `seconds`; null lets go. */
  push(pan: Hands["pan"], seconds: number): void {
    const { actions, state } = this;
    const push = pan && (pan.left !== 0 || pan.up !== 0) ? pan : null;
    if (!push) {
      if (this.#isPushed) actions.release(HOLDER);
      this.#isPushed = false;
      return;
    }
    if (!this.#isPushed) actions.press(HOLDER, STILL);
    this.#isPushed = true;
    // Until it is centred and pushed again, once something else has let go.
    if (!actions.deflect(HOLDER, STILL)) return;
    const axes = keyedAxes(state.hello.peek()?.robot.axes ?? []);
    for (const [at, share] of [push.left, push.up].entries()) {
      const axis = axes[at];
      if (axis === undefined || share === 0) continue;
      const moved = (state.axes.peek()[axis] ?? 0) + share * SHARE_PER_S * seconds;
      actions.setAxis(axis, Math.max(-1, Math.min(1, moved)));
    }
  }
}
