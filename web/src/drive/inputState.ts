/** What is held, and the motion it asks for; what ends it without a release: `letGo.ts`. */

/** `lateral_…` move sideways, on a robot that can; `left` and `right` turn. */
export type Direction = "forward" | "back" | "left" | "right" | "lateral_left" | "lateral_right";

export const DIRECTIONS: readonly Direction[] = [
  "forward",
  "back",
  "left",
  "right",
  "lateral_left",
  "lateral_right",
];

/** Fractions of the robot's limits; ahead and left are positive. */
export interface Motion {
  linear: number;
  angular: number;
  /** Sideways; absent for a robot that cannot move so. */
  lateral?: number;
}

/** What a holder holds; null for a control other than the wheels, such as an axis's slider. */
export type Held = Direction | Motion | null;

/** The holder for a finger or the mouse, wherever it touched down. */
export function fingerHolder(pointerId: number): string {
  return `pointer ${pointerId}`;
}

/**
 * A slider reports every change, whether by mouse, finger, key or assistive technology, but not
 * every release. So its axis counts as held for this long after the newest change: long enough for
 * six set-points at the slowest rate, in case the channel loses some, and short enough that a
 * slider that was left does not stay held.
 */
const TOUCH_MS = 300;

interface Touch {
  position: number;
  timer: ReturnType<typeof setTimeout>;
}

export interface InputStateOptions {
  /** Called synchronously whenever a holder is added or removed, or holds another direction. */
  changed: () => void;
  /** Called synchronously whenever a held stick changes its deflection. */
  deflected: () => void;
  movesSideways: () => boolean;
}

/**
 * What is held down, by which holder (a key, a finger, a stick, a focused button), and which axes
 * are touched.
 *
 * A holder releases only what it holds. A stick held in its middle moves nothing but counts as
 * held. While disabled nothing can be pressed, and enabling releases everything: a control held
 * since before a turn moves nothing until it is pressed again.
 */
export class InputState {
  #held = new Map<string, Held>();
  #touched = new Map<string, Touch>();
  #enabled = false;

  constructor(private readonly options: InputStateOptions) {}

  get isEnabled(): boolean {
    return this.#enabled;
  }

  /**
   * The sum of everything held, within the limits and rounded to thousandths to be short on the
   * wire; a direction counts once, however many holders it has. Ahead and sideways are one vector,
   * so that a diagonal is no faster than either alone.
   */
  get motion(): Motion {
    const share = (direction: Direction) => (this.holds(direction) ? 1 : 0);
    let linear = share("forward") - share("back");
    let angular = share("left") - share("right");
    let lateral = share("lateral_left") - share("lateral_right");
    for (const held of this.#held.values()) {
      if (!isMotion(held)) continue;
      linear += held.linear;
      angular += held.angular;
      lateral += held.lateral ?? 0;
    }
    if (!this.options.movesSideways()) return { linear: within(linear), angular: within(angular) };
    const length = Math.max(1, Math.hypot(linear, lateral));
    return {
      linear: within(linear / length),
      angular: within(angular),
      lateral: within(lateral / length),
    };
  }

  /** The positions of the axes that are held; the others keep theirs. */
  get axes(): Record<string, number> {
    return Object.fromEntries([...this.#touched].map(([axis, { position }]) => [axis, position]));
  }

  /** The dead-man switch: whether anything is held, even an axis or two opposite directions. */
  get isHolding(): boolean {
    return this.#held.size + this.#touched.size > 0;
  }

  holds(direction: Direction): boolean {
    return [...this.#held.values()].includes(direction);
  }

  isHeldBy(holder: string): boolean {
    return this.#held.has(holder);
  }

  /** Starts a turn with nothing held. */
  enable(): void {
    this.#enabled = true;
    this.releaseAll();
  }

  disable(): void {
    this.#enabled = false;
    this.releaseAll();
  }

  press(holder: string, held: Held): void {
    if (!this.#enabled || this.#held.get(holder) === held) return;
    this.#held.set(holder, held);
    this.options.changed();
  }

  /**
   * Moves the stick that this holder still holds. Returns false if it holds nothing: something has
   * released it, so the stick must be let go and taken again.
   */
  deflect(holder: string, motion: Motion): boolean {
    const held = this.#held.get(holder) ?? null;
    if (!isMotion(held)) return false;
    this.#held.set(holder, motion);
    const isSame =
      held.linear === motion.linear &&
      held.angular === motion.angular &&
      held.lateral === motion.lateral;
    if (!isSame) this.options.deflected();
    return true;
  }

  /** Returns false if this holder held nothing. */
  release(holder: string): boolean {
    const held = this.#held.delete(holder);
    if (held) this.options.changed();
    return held;
  }

  /** Handles a changed slider; only the first change of a touch calls `changed`. */
  touch(axis: string, position: number): void {
    if (!this.#enabled) return;
    const last = this.#touched.get(axis);
    clearTimeout(last?.timer);
    const timer = setTimeout(() => this.#leave(axis), TOUCH_MS);
    this.#touched.set(axis, { position, timer });
    if (!last) this.options.changed();
  }

  releaseAll(): void {
    if (!this.isHolding) return;
    this.#held.clear();
    for (const { timer } of this.#touched.values()) clearTimeout(timer);
    this.#touched.clear();
    this.options.changed();
  }

  #leave(axis: string): void {
    this.#touched.delete(axis);
    this.options.changed();
  }
}

/** Whether it asks for any movement. */
export function isMoving({ linear, angular, lateral = 0 }: Motion): boolean {
  return linear !== 0 || angular !== 0 || lateral !== 0;
}

function isMotion(held: Held): held is Motion {
  return typeof held === "object" && held !== null;
}

function within(fraction: number): number {
  return Math.max(-1, Math.min(1, Math.round(fraction * 1000) / 1000)) + 0;
}
