/** Whether the server has accepted a press of Stop, as far as this page can know. Pure. */

/** The user is warned within 2 s, given that pages check every 200 ms. */
const CONFIRM_MS = 1600;
const AGAIN_MS = 4000;
/** A later retry would surprise more than help: the user is asked to press again instead. */
const TRIED_FOR_MS = 30_000;
/** The room's message, by which the card shows who stopped the robot, is awaited for this long. */
const SHOWN_MS = 600;

/**
 * One press of Stop, until its fate is known. `before` is the stop that this page believed to be in
 * force at the press, which may be out of date: seeing it still there proves nothing. `sinceMs` is
 * when the first of several unanswered presses was made.
 */
export class StopPress {
  /** Identifies the press to the server, however late and often it arrives. */
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

  /** The number of the stop that it became; null while unknown. */
  get taken(): number | null {
    return this.#taken?.stop ?? null;
  }

  /** Records the server's answer to this very press. */
  answered(stop: number, nowMs: number): void {
    this.#taken ??= { stop, atMs: nowMs };
  }

  /** Records the stop that the room shows in force. */
  sawStop(stop: number | null, nowMs: number): void {
    if (stop !== null && stop !== this.before) this.answered(stop, nowMs);
  }

  /** Whether to warn the user that the press is not confirmed. */
  isUnconfirmed(nowMs: number): boolean {
    return this.#taken === null && nowMs - this.sinceMs >= CONFIRM_MS;
  }

  /** Whether the card has had time to show it. */
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

  /** Records a retry. */
  tried(nowMs: number): void {
    this.#triedMs = nowMs;
  }
}
