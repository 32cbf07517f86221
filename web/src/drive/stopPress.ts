/** Whether the robot's server has taken a press of Stop, as far as this page can know. Pure. */

/** The person who pressed is told before 2 s are over; pages look each 200 ms. */
const CONFIRM_MS = 1600;
const AGAIN_MS = 4000;
/** What comes later than that surprises people more than it helps: they are asked to press again. */
const TRIED_FOR_MS = 30_000;
/** The card says by whom the robot is stopped, unless the room's message comes too late for that. */
const SHOWN_MS = 600;

/**
 * One press of Stop, until it is known what became of it. `before` is the stop that this page
 * believed to be in force then, which may be out of date: seeing it still there proves nothing.
 * `sinceMs` is when the first of several presses was made that nobody has answered.
 */
export class StopPress {
  /** By this the server knows it again, whenever and however often it comes. */
  readonly number = Math.floor(Math.random() * 2 ** 53);
  #triedMs: number;
  #taken: { stop: number; atMs: number } | null = null;

  constructor(
    private readonly before: number | null,
    private readonly pressedMs: number,
    readonly sinceMs = pressedMs,
  ) {
    this.#triedMs = pressedMs;
  }

  /** The number of the stop that it became, null while that is not known. */
  get taken(): number | null {
    return this.#taken?.stop ?? null;
  }

  /** The server has answered this very press. */
  answered(stop: number, nowMs: number): void {
    this.#taken ??= { stop, atMs: nowMs };
  }

  /** The room has this stop in force. */
  told(stop: number | null, nowMs: number): void {
    if (stop !== null && stop !== this.before) this.answered(stop, nowMs);
  }

  /** Whether to tell people that nobody has confirmed it. */
  isUnconfirmed(nowMs: number): boolean {
    return this.#taken === null && nowMs - this.sinceMs >= CONFIRM_MS;
  }

  /** Whether the card has had the time to show it. */
  isSettled(nowMs: number): boolean {
    return this.#taken !== null && nowMs - this.#taken.atMs >= SHOWN_MS;
  }

  /** Whether it may still be sent again. */
  mayTry(nowMs: number): boolean {
    return this.#taken === null && nowMs - this.pressedMs < TRIED_FOR_MS;
  }

  /** Whether to send it again now. */
  isDue(nowMs: number): boolean {
    const isFirst = this.#triedMs === this.pressedMs;
    return this.mayTry(nowMs) && nowMs - this.#triedMs >= (isFirst ? CONFIRM_MS : AGAIN_MS);
  }

  /** It was sent again. */
  tried(nowMs: number): void {
    this.#triedMs = nowMs;
  }
}
