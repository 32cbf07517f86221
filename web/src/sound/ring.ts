/** The smallest Opus frame, 2.5 ms; all packets are multiples of it. */
const CELL = 120;
/** Almost 3 s. */
const CELLS = 1200;
const SIZE = CELL * CELLS;

/** The left ear and the right. */
export type Side = 0 | 1;

/** Decoded stereo sound by its time; reads 0 where nothing has arrived. Pure. */
export class Ring {
  readonly #samples = [new Float32Array(SIZE), new Float32Array(SIZE)] as const;
  /** Which cell of time is in each cell of the ring. */
  readonly #holds = new Float64Array(CELLS).fill(-1);
  /** The time after the newest sample. */
  end = 0;

  /** Writes samples from `at` on; `at` and their number must be multiples of 2.5 ms. */
  write(at: number, left: Float32Array, right: Float32Array = left): void {
    for (let i = 0; i + CELL <= left.length; i += CELL) {
      const cell = (at + i) / CELL;
      const slot = cell % CELLS;
      this.#holds[slot] = cell;
      this.#samples[0].set(left.subarray(i, i + CELL), slot * CELL);
      this.#samples[1].set(right.subarray(i, i + CELL), slot * CELL);
    }
    this.end = Math.max(this.end, at + left.length);
  }

  /** Whether all samples in this range of time have arrived. */
  has(from: number, to: number): boolean {
    for (let cell = Math.floor(from / CELL); cell * CELL < to; cell++) {
      if (cell < 0 || this.#holds[cell % CELLS] !== cell) return false;
    }
    return true;
  }

  /** The first time from this one on that has samples, else the end. */
  nextFrom(time: number): number {
    let cell = Math.floor(time / CELL);
    if (this.#holds[cell % CELLS] === cell) return time;
    while (cell * CELL < this.end && this.#holds[cell % CELLS] !== cell) cell++;
    return Math.min(cell * CELL, this.end);
  }

  at(time: number, side: Side): number {
    const cell = Math.floor(time / CELL);
    if (cell < 0 || this.#holds[cell % CELLS] !== cell) return 0;
    return this.#samples[side][time % SIZE] ?? 0;
  }

  /** Interpolates between samples, by a Catmull–Rom spline through four of them. */
  between(time: number, side: Side): number {
    const at = Math.floor(time);
    const t = time - at;
    const b = this.at(at, side);
    if (t === 0) return b;
    const a = this.at(at - 1, side);
    const c = this.at(at + 1, side);
    const d = this.at(at + 2, side);
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  }

  clear(): void {
    this.#holds.fill(-1);
    this.end = 0;
  }
}
