/** The quietest level shown, in dB of full scale. */
const QUIET_DB = -60;

/** A mean square, full scale being 1, in even steps of loudness: 0 at −60 dB, 1 at 0 dB. Pure. */
export function levelOfPower(power: number): number {
  const db = 10 * Math.log10(power + 1e-12);
  return Math.min(1, Math.max(0, 1 - db / QUIET_DB));
}

/** The loudness of each channel since the last look. Pure. */
export class LevelMeter {
  readonly #sums = [0, 0];
  #count = 0;

  add(channels: readonly Float32Array[]): void {
    for (let side = 0; side < this.#sums.length; side++) {
      let sum = 0;
      for (const sample of channels[side] ?? []) sum += sample * sample;
      this.#sums[side] = (this.#sums[side] ?? 0) + sum;
    }
    this.#count += channels[0]?.length ?? 0;
  }

  /** The levels from 0 to 1, left first. */
  take(): number[] {
    const levels = this.#sums.map((sum) => levelOfPower(sum / Math.max(1, this.#count)));
    this.#sums.fill(0);
    this.#count = 0;
    return levels;
  }
}
