/** A plot's line in figures, for users who cannot see it. Pure. */

export interface Summary {
  least: number;
  median: number;
  most: number;
  newest: number;
}

/** Summarises the known values; null if there are none. */
export function summary(values: readonly (number | null)[]): Summary | null {
  const known = values.filter((value) => value !== null);
  const sorted = known.toSorted((a, b) => a - b);
  const [least, most, newest] = [sorted[0], sorted.at(-1), known.at(-1)];
  if (least === undefined || most === undefined || newest === undefined) return null;
  return { least, median: median(sorted) ?? least, most, newest };
}

/** The middle value, or the mean of the two; null for none. */
export function median(values: readonly number[]): number | null {
  const sorted = values.toSorted((a, b) => a - b);
  const [low, high] = [
    sorted[Math.ceil(sorted.length / 2) - 1],
    sorted[Math.floor(sorted.length / 2)],
  ];
  return low === undefined || high === undefined ? null : (low + high) / 2;
}
