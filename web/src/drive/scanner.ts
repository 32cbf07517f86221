/** What is offered to whoever drives by one or two switches, in which order, and for how long. */

import type { Direction } from "./inputState";

/** What a switch can choose: `release` is that of the stop in force. */
export type ScanItem = Direction | "stop" | "release";

/** What follows each; where the robot is stopped there is nothing else to choose. */
const NEXT: Record<ScanItem, ScanItem> = {
  forward: "left",
  left: "right",
  right: "back",
  back: "stop",
  stop: "forward",
  release: "release",
};

export interface ScannerOptions {
  /** How long each is offered; null if a second switch moves on. */
  dwellMs: () => number | null;
  /** Shows what is offered, null for nothing. */
  offer: (item: ScanItem | null) => void;
  choose: (item: ScanItem) => void;
}

/** Offers one thing after another to somebody who has one or two switches. */
export class Scanner {
  #item: ScanItem | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly options: ScannerOptions) {}

  /** Begins with ahead, which is chosen most. */
  begin(isStopped: boolean): void {
    this.#offer(isStopped ? "release" : "forward");
  }

  end(): void {
    clearTimeout(this.#timer);
    this.#item = null;
    this.options.offer(null);
  }

  next(): void {
    if (this.#item !== null) this.#offer(NEXT[this.#item]);
  }

  /** Chooses what is offered, and offers it once more, since the same step often follows. */
  select(): void {
    if (this.#item === null) return;
    this.#dwell();
    this.options.choose(this.#item);
  }

  #offer(item: ScanItem): void {
    this.#item = item;
    this.options.offer(item);
    this.#dwell();
  }

  #dwell(): void {
    clearTimeout(this.#timer);
    const ms = this.options.dwellMs();
    if (ms !== null) this.#timer = setTimeout(() => this.next(), ms);
  }
}
