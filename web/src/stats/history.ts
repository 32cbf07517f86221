/** What was measured and what happened in the last minutes, in bounded memory. Pure. */

/** What each sample holds besides its time; null where unknown. */
export const FIELDS = [
  "pictureMs",
  "soundMs",
  "skewMs",
  "jitterMs",
  "bufferMs",
  "roundTripMs",
  "heldMs",
  "linkBps",
  "usedBps",
  "queueMs",
  "widthPx",
  "askedPx",
  "sentHz",
  "arrivedHz",
  "shownHz",
] as const;

export type Field = (typeof FIELDS)[number];

/**
 * One moment, on the page's clock. `heldMs` is the minimum time that a picture waits for the sound,
 * `widthPx` the width of the pictures sent (0 for none) and `askedPx` of those requested; `sentHz`,
 * `arrivedHz` and `shownHz` count the pictures that the server sends, that arrive, and that the
 * browser presents.
 */
export type Sample = { atMs: number } & Record<Field, number | null>;

/** Something that a person did or the server decided; the sentence names nobody. */
export interface Mark {
  atMs: number;
  kind: "link" | "turn" | "stop" | "robot" | "policy" | "sent" | "player";
  text: string;
}

/** Ten minutes at the usual one sample a second; two and a half at the highest rate accepted. */
export const MOST_SAMPLES = 600;
export const MOST_MARKS = 200;
const LEAST_GAP_MS = 250;

export class History {
  readonly #atMs = new Float64Array(MOST_SAMPLES);
  readonly #columns = FIELDS.map(() => new Float64Array(MOST_SAMPLES));
  #added = 0;
  #marks: Mark[] = [];

  /** The number of samples that are kept. */
  get length(): number {
    return Math.min(this.#added, MOST_SAMPLES);
  }

  /** When the newest sample was taken; null before the first. */
  get newestMs(): number | null {
    return this.#added === 0 ? null : this.#at(this.length - 1, this.#atMs);
  }

  get marks(): readonly Mark[] {
    return this.#marks;
  }

  /** Adds a sample; returns false if it comes too soon after the last. */
  add(sample: Sample): boolean {
    if (sample.atMs - (this.newestMs ?? Number.NEGATIVE_INFINITY) < LEAST_GAP_MS) return false;
    const slot = this.#added++ % MOST_SAMPLES;
    this.#atMs[slot] = sample.atMs;
    FIELDS.forEach((field, i) => {
      const column = this.#columns[i];
      if (column) column[slot] = sample[field] ?? Number.NaN;
    });
    return true;
  }

  mark(mark: Mark): void {
    this.#marks.push(mark);
    if (this.#marks.length > MOST_MARKS) this.#marks.shift();
  }

  /** The times of the samples, oldest first. */
  times(): number[] {
    return Array.from({ length: this.length }, (_, i) => this.#at(i, this.#atMs));
  }

  /** One field of all samples, oldest first. */
  column(field: Field): (number | null)[] {
    const column = this.#columns[FIELDS.indexOf(field)];
    return Array.from({ length: this.length }, (_, i) =>
      column ? known(this.#at(i, column)) : null,
    );
  }

  /** The known values of one field since `sinceMs`. */
  since(field: Field, sinceMs: number): number[] {
    const times = this.times();
    return this.column(field).filter(
      (value, i): value is number => value !== null && (times[i] ?? 0) >= sinceMs,
    );
  }

  #at(i: number, column: Float64Array): number {
    return column[(this.#added - this.length + i) % MOST_SAMPLES] ?? Number.NaN;
  }
}

function known(value: number): number | null {
  return Number.isNaN(value) ? null : value;
}
