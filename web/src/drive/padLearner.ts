/** Finds the part of a gamepad that the user presses or pushes to choose it. Pure. */

import type { LearntPart } from "./learntParts";
import type { Pad } from "./padReading";

/** A smaller movement is a tremble, or a stick beside the one that is meant. */
const PUSHED = 0.5;
/** As far from where it began, an axis counts as released. */
const BACK = 0.25;
const TREMBLE = 0.05;
/** A throttle does not spring back: it is chosen once it has stood at its end for this long. */
const STOOD_MS = 500;

/** The part, and where its axis began: for a throttle, where it rests. */
export interface Found extends LearntPart {
  from: number;
}

/** Feed it readings, from one with everything released on. */
export class PadLearner {
  readonly #down: Set<number>;
  readonly #from: readonly number[];
  #pushed: Found | null = null;
  #stillAt = Number.POSITIVE_INFINITY;
  #stillMs = 0;

  constructor(
    { axes, buttons }: Pad,
    private readonly isAxisWanted: boolean,
  ) {
    this.#from = [...axes];
    this.#down = new Set(buttons.flatMap(({ pressed }, at) => (pressed ? [at] : [])));
  }

  /** Returns the part once it is known. */
  next({ axes, buttons }: Pad, nowMs: number): Found | null {
    if (!this.isAxisWanted) {
      // A button held at the beginning opened this choice, perhaps.
      for (const at of this.#down) if (!buttons[at]?.pressed) this.#down.delete(at);
      const at = buttons.findIndex(({ pressed }, i) => pressed && !this.#down.has(i));
      if (at >= 0) return { kind: "button", at, to: 1, from: 0 };
    }
    this.#follow(axes, nowMs);
    const found = this.#pushed;
    if (!found) return null;
    const isBack = Math.abs((axes[found.at] ?? found.from) - found.from) < BACK;
    return isBack || nowMs - this.#stillMs >= STOOD_MS ? found : null;
  }

  /** Follows the first axis that is pushed, to its end. */
  #follow(axes: readonly number[], nowMs: number): void {
    const pushed = this.#pushed;
    const isPushed = (from: number, at: number) => Math.abs((axes[at] ?? from) - from) > PUSHED;
    const at = pushed?.at ?? this.#from.findIndex(isPushed);
    const [from, to] = [this.#from[at], axes[at]];
    if (from === undefined || to === undefined) return;
    if (Math.abs(to - this.#stillAt) > TREMBLE) [this.#stillAt, this.#stillMs] = [to, nowMs];
    if (pushed && Math.abs(to - from) <= Math.abs(pushed.to - from)) return;
    this.#pushed = { kind: "axis", at, to, from };
  }
}
