/** A voice's pitch is between 66 and 400 Hz. */
const SHORTEST = 120;
export const LONGEST = 720;
export const COMPARED = 480;
const STEP = 4;

/**
 * Returns the period of the sound before `time`, in samples: the shift at which it best matches
 * itself. Pure.
 */
export function periodBefore(at: (time: number) => number, time: number): number {
  // Read once: the audio thread has no time to call `at` for each pair.
  const read = (COMPARED + LONGEST) / STEP;
  const heard = Float64Array.from({ length: read }, (_, i) => at(time - 1 - i * STEP));
  const compared = heard.subarray(0, COMPARED / STEP);
  const energy = compared.reduce((sum, one) => sum + one * one, 1e-9);
  let best = SHORTEST;
  let most = -1;
  for (let shift = SHORTEST; shift <= LONGEST; shift += STEP) {
    let product = 0;
    let other = 1e-9;
    for (let i = 0; i < compared.length; i++) {
      const b = heard[i + shift / STEP] ?? 0;
      product += (compared[i] ?? 0) * b;
      other += b * b;
    }
    const likeness = product / Math.sqrt(energy * other);
    if (likeness > most + 1e-3) {
      most = likeness;
      best = shift;
    }
  }
  return best;
}
