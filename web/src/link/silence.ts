/** After this long without a message, a ping checks whether the server answers. */
const ASK_AFTER_MS = 300;
/** How much longer than recent round trips such a ping may take. */
const PATIENCE_MS = 300;
const SILENT_AFTER_MS = 700;
/** A modem stalls for a second now and then, which does not matter. */
const THIN_SILENT_AFTER_MS = 1500;
/** A longer gap between calls means that the page did not run and could not receive anything. */
const LONGEST_STEP_MS = 200;

/**
 * How long nothing has arrived: nothing from the server, or no picture of a camera. Pure.
 *
 * Only time in which the page runs counts. A tab in the background, or one that was frozen, runs
 * its timers before it handles what has arrived meanwhile.
 */
export class Silence {
  #heardMs: number;
  #lookedMs: number;
  #quietMs = 0;

  constructor(nowMs: number) {
    this.#heardMs = nowMs;
    this.#lookedMs = nowMs;
  }

  /** When something last arrived. */
  get sinceMs(): number {
    return this.#heardMs;
  }

  /** Records that something has arrived. */
  heard(nowMs: number): void {
    this.#heardMs = nowMs;
    this.#lookedMs = nowMs;
    this.#quietMs = 0;
  }

  /** How much of that time the page ran. */
  get quietMs(): number {
    return this.#quietMs;
  }

  /** Updates the time; call a few times a second. */
  update(nowMs: number): void {
    this.#quietMs += Math.min(nowMs - this.#lookedMs, LONGEST_STEP_MS);
    this.#lookedMs = nowMs;
  }

  /** Whether to send a ping now. */
  get isDoubtful(): boolean {
    return this.#quietMs >= ASK_AFTER_MS;
  }

  /**
   * Whether the server does not answer: `unansweredMs` is how long the oldest ping has had no
   * answer, `slowestMs` the longest recent round trip.
   */
  isSilent(unansweredMs: number, slowestMs: number, isThin: boolean): boolean {
    const afterMs = isThin ? THIN_SILENT_AFTER_MS : SILENT_AFTER_MS;
    return this.#quietMs >= afterMs && unansweredMs >= slowestMs + PATIENCE_MS;
  }
}
