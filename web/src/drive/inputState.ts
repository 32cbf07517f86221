export type Direction = "forward" | "back" | "left" | "right";

/** Shares of the robot's limits: ahead and left are positive. */
export interface Motion {
  linear: number;
  angular: number;
}

/** What a finger, or the mouse, holds by: one holder wherever it came down. */
export function fingerHolder(pointerId: number): string {
  return `pointer ${pointerId}`;
}

/**
 * A slider tells of every change, whether a mouse, a finger, a key or another aid made it, but not
 * of every hand that leaves it. So a hand is on its axis for this long after the newest change:
 * long enough for six set-points at the slowest rate, should the channel lose some, and short
 * enough that nobody counts as holding what they have left.
 */
const TOUCH_MS = 300;

interface Touch {
  position: number;
  timer: ReturnType<typeof setTimeout>;
}

/**
 * What is held down, by whatever holds it: a key, a finger, a button that has the focus; and what
 * axes are touched.
 *
 * Each holder releases only itself. While disabled nothing can be pressed, and enabling releases
 * all: what was held down before a turn began moves nothing in it until it is pressed anew.
 */
export class InputState {
  #held = new Map<string, Direction | null>();
  #touched = new Map<string, Touch>();
  #enabled = false;

  /** `onChange` is called in the same turn of the event loop, whenever what is held changes. */
  constructor(private readonly onChange: () => void) {}

  get motion(): Motion {
    const share = (direction: Direction) => (this.holds(direction) ? 1 : 0);
    return {
      linear: share("forward") - share("back"),
      angular: share("left") - share("right"),
    };
  }

  /** Where the axes shall be that have a hand on them now; the others stay where they are. */
  get axes(): Record<string, number> {
    return Object.fromEntries([...this.#touched].map(([axis, { position }]) => [axis, position]));
  }

  /** The dead-man: whether anything is held, though two opposites, or an axis, make no motion. */
  get isHolding(): boolean {
    return this.#held.size + this.#touched.size > 0;
  }

  holds(direction: Direction): boolean {
    return [...this.#held.values()].includes(direction);
  }

  /** Starts a turn of driving, with nothing held. */
  enable(): void {
    this.#enabled = true;
    this.releaseAll();
  }

  disable(): void {
    this.#enabled = false;
    this.releaseAll();
  }

  /** Holds a direction, or null for a control that has none, such as the slider of an axis. */
  press(holder: string, direction: Direction | null): void {
    if (!this.#enabled || this.#held.get(holder) === direction) return;
    this.#held.set(holder, direction);
    this.onChange();
  }

  /** False where this holder held nothing. */
  release(holder: string): boolean {
    const held = this.#held.delete(holder);
    if (held) this.onChange();
    return held;
  }

  /** A slider was changed. Only a hand that was not there before is told of at once. */
  touch(axis: string, position: number): void {
    if (!this.#enabled) return;
    const last = this.#touched.get(axis);
    clearTimeout(last?.timer);
    const timer = setTimeout(() => this.#leave(axis), TOUCH_MS);
    this.#touched.set(axis, { position, timer });
    if (!last) this.onChange();
  }

  releaseAll(): void {
    if (!this.isHolding) return;
    this.#held.clear();
    for (const { timer } of this.#touched.values()) clearTimeout(timer);
    this.#touched.clear();
    this.onChange();
  }

  #leave(axis: string): void {
    this.#touched.delete(axis);
    this.onChange();
  }
}
