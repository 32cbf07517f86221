/** A voice's pitch is between 66 and 400 Hz. */
const SHORTEST = 120;
export const LONGEST = 720;
export const COMPARED = 480;
const STEP = 4;

/**
 * Returns the length of the period of the sound before `time`, in samples: the shift at which it is
 * most like itself. Pure.
 */
export function periodBefore(at: (time: number) => number, time: number): number {
  let best = SHORTEST;
  let most = -1;
  for (let shift = SHORTEST; shift <= LONGEST; shift += STEP) {
    let product = 0;
    let energy = 1e-9;
    let other = 1e-9;
    for (let i = 0; i < COMPARED; i += STEP) {
      const a = at(time - 1 - i);
      const b = at(time - 1 - i - shift);
      product += a * b;
      energy += a * a;
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
