/** Moments of a history, for tests. */
import { FIELDS, type Sample } from "../stats/history";

export function sample(atMs: number, more: Partial<Sample> = {}): Sample {
  const nothing = Object.fromEntries(FIELDS.map((field) => [field, null])) as Omit<Sample, "atMs">;
  return { ...nothing, atMs, ...more };
}
