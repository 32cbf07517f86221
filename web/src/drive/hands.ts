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
 * What is held down, by whatever holds it: a key, a finger, a button that has the focus.
 *
 * Each holder releases only itself. While disabled nothing can be pressed, and enabling releases
 * all: what was held down before a turn began moves nothing in it until it is pressed anew.
 */
export class Hands {
  #held = new Map<string, Direction | null>();
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

  /** The dead-man: whether anything is held, though two opposites make no motion. */
  get isHolding(): boolean {
    return this.#held.size > 0;
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

  releaseAll(): void {
    if (this.#held.size === 0) return;
    this.#held.clear();
    this.onChange();
  }
}
