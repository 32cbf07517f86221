/** The quietest level shown, in dB of full scale. */
const QUIET_DB = -60;

/** Maps a mean square (full scale 1) linearly in dB: 0 at −60 dB, 1 at 0 dB. Pure. */
export function levelOfPower(power: number): number {
  const db = 10 * Math.log10(power + 1e-12);
  return Math.min(1, Math.max(0, 1 - db / QUIET_DB));
}

/** The level of each channel since the last reading, without its DC offset. Pure. */
export class LevelMeter {
  readonly #sums = [0, 0];
  readonly #squares = [0, 0];
  #count = 0;

  add(channels: readonly Float32Array[]): void {
    for (let side = 0; side < this.#sums.length; side++) {
      let [sum, squares] = [0, 0];
      for (const sample of channels[side] ?? []) {
        sum += sample;
        squares += sample * sample;
      }
      this.#sums[side] = (this.#sums[side] ?? 0) + sum;
      this.#squares[side] = (this.#squares[side] ?? 0) + squares;
    }
    this.#count += channels[0]?.length ?? 0;
  }

  /** The levels from 0 to 1, left first. */
  flush(): number[] {
    const count = Math.max(1, this.#count);
    const levels = this.#squares.map((squares, side) => {
      const mean = (this.#sums[side] ?? 0) / count;
      return levelOfPower(Math.max(0, squares / count - mean * mean));
    });
    this.#sums.fill(0);
    this.#squares.fill(0);
    this.#count = 0;
    return levels;
  }
}
