/** The most by which an observer's picture waits for its sound (thesis 3.3). */
const MOST_MS = 500;
const STEP_MS = 10;
/** Smaller errors are ignored: they come from rounding and noise. */
const SURE_MS = 8;
/** Sound later than this is noticed (ITU-R BT.1359): if more would remain, do not wait. */
const NOTICED_MS = 125;
/** Several measurements decide, since single ones vary with the picture's jitter. */
const SAMPLES = 4;
/** Browsers change the picture's delay by 100 ms a second, and need a few pictures to start. */
const BEGINS_MS = 500;
const MOVES = 10;

/**
 * How long the picture is held back, to be shown when its sound is heard: the sound is the master,
 * as at the robot's own server. After a change, measurements count only once it has settled. Pure.
 */
export class HoldBack {
  #heldMs = 0;
  #early: number[] = [];
  #settledMs = Number.NEGATIVE_INFINITY;

  get heldMs(): number {
    return this.#heldMs;
  }

  /** Adds a measurement: by how much the picture is younger than the sound. */
  add(earlyMs: number, nowMs: number): void {
    if (nowMs < this.#settledMs) return;
    this.#early.push(earlyMs);
    if (this.#early.length < SAMPLES) return;
    const sorted = this.#early.splice(0).sort((a, b) => a - b);
    const middle = ((sorted[1] ?? 0) + (sorted[2] ?? 0)) / 2;
    if (Math.abs(middle) >= SURE_MS) this.#hold(this.#heldMs + middle, nowMs);
  }

  /** Restarts with a new jitter buffer, which is to hold back as much. */
  restart(nowMs: number): void {
    this.#early = [];
    this.#settledMs = nowMs + BEGINS_MS + MOVES * this.#heldMs;
  }

  /** Holds nothing back: there is no sound to wait for. */
  forget(): void {
    this.#heldMs = 0;
    this.#early = [];
    this.#settledMs = Number.NEGATIVE_INFINITY;
  }

  #hold(wantedMs: number, nowMs: number): void {
    const isVain = wantedMs - MOST_MS > NOTICED_MS;
    const roundedMs = Math.round(wantedMs / STEP_MS) * STEP_MS;
    const heldMs = isVain ? 0 : Math.min(Math.max(roundedMs, 0), MOST_MS);
    this.#settledMs = nowMs + BEGINS_MS + MOVES * Math.abs(heldMs - this.#heldMs);
    this.#heldMs = heldMs;
  }
}
