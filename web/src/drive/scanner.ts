/** What is offered to a user with one or two switches, in which order, and for how long. */

import type { Direction } from "./inputState";

/** What a switch can choose; `release` releases the stop in force. */
export type ScanItem = Direction | "stop" | "release";

type Items = readonly [ScanItem, ...ScanItem[]];

const DRIVING: Items = ["forward", "left", "right", "back", "stop"];
const SIDEWAYS: Items = [
  "forward",
  "left",
  "right",
  "lateral_left",
  "lateral_right",
  "back",
  "stop",
];
const STOPPED: Items = ["release"];

/** What is offered, in turn: only the release while the robot is stopped. Pure. */
export function scanItems(isStopped: boolean, movesSideways: boolean): Items {
  if (isStopped) return STOPPED;
  return movesSideways ? SIDEWAYS : DRIVING;
}

export interface ScannerOptions {
  /** How long each item is offered; null if a second switch moves on. */
  dwellMs: () => number | null;
  movesSideways: () => boolean;
  /** Shows what is offered, null for nothing. */
  offer: (item: ScanItem | null) => void;
  choose: (item: ScanItem) => void;
}

/** Offers one item after another to a user with one or two switches. */
export class Scanner {
  #item: ScanItem | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly options: ScannerOptions) {}

  /** Starts with ahead, which is chosen most. */
  begin(isStopped: boolean): void {
    this.#offer(isStopped ? "release" : "forward");
  }

  end(): void {
    clearTimeout(this.#timer);
    this.#item = null;
    this.options.offer(null);
  }

  next(): void {
    if (this.#item === null) return;
    const items = scanItems(this.#item === "release", this.options.movesSideways());
    this.#offer(items[items.indexOf(this.#item) + 1] ?? items[0]);
  }

  /** Chooses the offered item and offers it again, since the same step often follows. */
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
