/** Without a word for so long, a ping asks whether anybody is there. */
const ASK_AFTER_MS = 300;
/** How long such a ping may take beyond the round trips of late. */
const PATIENCE_MS = 300;
const SILENT_AFTER_MS = 700;
/** A modem stalls for a second now and then; that is no news. */
const THIN_SILENT_AFTER_MS = 1500;
/** A page that was not asked for longer than this did not run; it could not have heard anything. */
const LONGEST_STEP_MS = 200;

/**
 * For how long nothing has been heard of the server: neither a message nor a picture. Pure.
 *
 * Only time in which the page runs counts. A tab in the background, or one that was frozen, runs
 * its timers before it takes what has arrived meanwhile.
 */
export class Silence {
  #heardMs: number;
  #lookedMs: number;
  #quietMs = 0;

  constructor(nowMs: number) {
    this.#heardMs = nowMs;
    this.#lookedMs = nowMs;
  }

  /** When something was heard last. */
  get sinceMs(): number {
    return this.#heardMs;
  }

  /** Whatever has come shows that the server is there. */
  heard(nowMs: number): void {
    this.#heardMs = nowMs;
    this.#lookedMs = nowMs;
    this.#quietMs = 0;
  }

  /** Lets the time pass; call a few times a second. */
  look(nowMs: number): void {
    this.#quietMs += Math.min(nowMs - this.#lookedMs, LONGEST_STEP_MS);
    this.#lookedMs = nowMs;
  }

  /** It is time to ask. */
  get isDoubtful(): boolean {
    return this.#quietMs >= ASK_AFTER_MS;
  }

  /**
   * The server does not answer: `unansweredMs` is for how long the oldest ping is without an
   * answer, `slowestMs` the longest round trip of late.
   */
  isSilent(unansweredMs: number, slowestMs: number, isThin: boolean): boolean {
    const afterMs = isThin ? THIN_SILENT_AFTER_MS : SILENT_AFTER_MS;
    return this.#quietMs >= afterMs && unansweredMs >= slowestMs + PATIENCE_MS;
  }
}
