export type Direction = "forward" | "back" | "left" | "right";

/** Fractions of the robot's limits: ahead and left are positive. */
export interface Motion {
  linear: number;
  angular: number;
}

/** The holder for a finger or the mouse: the same wherever it touched down. */
export function fingerHolder(pointerId: number): string {
  return `pointer ${pointerId}`;
}

/**
 * A slider reports every change, whether by mouse, finger, key or assistive technology, but not
 * every release. So its axis counts as held for this long after the newest change: long enough for
 * six set-points at the slowest rate, in case the channel loses some, and short enough that nobody
 * counts as holding what they have left.
 */
const TOUCH_MS = 300;

interface Touch {
  position: number;
  timer: ReturnType<typeof setTimeout>;
}

/**
 * What is held down, and by which holder (a key, a finger, a focused button), and which axes are
 * touched.
 *
 * A holder releases only what it holds. While disabled nothing can be pressed, and enabling releases
 * everything: a control held since before a turn moves nothing until it is pressed again.
 */
export class InputState {
  #held = new Map<string, Direction | null>();
  #touched = new Map<string, Touch>();
  #enabled = false;

  /** `onChange` is called synchronously whenever what is held changes. */
  constructor(private readonly onChange: () => void) {}

  get motion(): Motion {
    const share = (direction: Direction) => (this.holds(direction) ? 1 : 0);
    return {
      linear: share("forward") - share("back"),
      angular: share("left") - share("right"),
    };
  }

  /** The positions of the axes being held; the others keep theirs. */
  get axes(): Record<string, number> {
    return Object.fromEntries([...this.#touched].map(([axis, { position }]) => [axis, position]));
  }

  /** The dead-man: whether anything is held, even an axis or two opposite directions. */
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

  /** Holds a direction, or null for a control without one, such as the slider of an axis. */
  press(holder: string, direction: Direction | null): void {
    if (!this.#enabled || this.#held.get(holder) === direction) return;
    this.#held.set(holder, direction);
    this.onChange();
  }

  /** Returns false if this holder held nothing. */
  release(holder: string): boolean {
    const held = this.#held.delete(holder);
    if (held) this.onChange();
    return held;
  }

  /** Handles a changed slider; only the first change of a touch calls `onChange`. */
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
