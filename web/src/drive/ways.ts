import type { Direction, Held, InputState } from "./inputState";

/**
 * How a direction drives. `hold`: while it is held. `step`: each press is one short, slow move.
 * `click`: each press moves for a while, or until the next press. `scan`: the directions are
 * offered one after another, and a switch makes a step of the one on offer.
 */
export const WAYS = ["hold", "step", "click", "scan"] as const;
export type Way = (typeof WAYS)[number];

/** How long a click moves the robot at most. */
export const CLICK_MS = 2000;
/** The holder of a step's or a click's direction, which no finger holds. */
const MOVE = "move";

export interface WaysOptions {
  input: InputState;
  way: () => Way;
  stepMs: () => number;
}

/**
 * Handles presses of directions in the chosen way. A timed move is a holder like any other, so
 * everything that releases the controls ends it, not only its timer.
 */
export class Ways {
  #timer: ReturnType<typeof setTimeout> | undefined;
  /** The holder that started the move. */
  #by = "";

  constructor(private readonly options: WaysOptions) {}

  /** Whether a step is moving, which is slow at any speed. */
  get isStepping(): boolean {
    return this.options.way() !== "click" && this.options.input.isHeldBy(MOVE);
  }

  press(holder: string, held: Held): void {
    const { input, way, stepMs } = this.options;
    if (typeof held === "string" && way() !== "hold") {
      this.#move(holder, held, way() === "click" ? CLICK_MS : stepMs());
      return;
    }
    this.interrupt();
    input.press(holder, held);
  }

  /** Handles a direction key: with clicks it ends the move and is held itself. */
  pressKey(holder: string, direction: Direction): void {
    if (this.options.way() === "click") this.options.input.press(holder, direction);
    else this.press(holder, direction);
  }

  /** Returns false if this holder itself held nothing. */
  release(holder: string): boolean {
    return this.options.input.release(holder);
  }

  /** Handles a touch that the system has cancelled; returns whether anything depended on it. */
  cancel(holder: string): boolean {
    const { input } = this.options;
    const isItsMove = this.#by === holder && input.isHeldBy(MOVE);
    return input.release(holder) || isItsMove;
  }

  /** Makes one short move, whatever the way. */
  step(holder: string, direction: Direction): void {
    this.#move(holder, direction, this.options.stepMs());
  }

  /** Ends a click's move, because something else was clicked or pressed. */
  interrupt(): void {
    if (this.options.way() === "click") this.options.input.release(MOVE);
  }

  #move(holder: string, direction: Direction, ms: number): void {
    clearTimeout(this.#timer);
    this.#by = holder;
    this.options.input.press(MOVE, direction);
    this.#timer = setTimeout(() => this.options.input.release(MOVE), ms);
  }
}
