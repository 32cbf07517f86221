/** When to try again after losing a connection: soon, then less and less often. */

const DELAYS_MS = [0, 300, 1200, 2700, 4800, 7000] as const;
const LAST_MS = 7000;
const MAX_JITTER_MS = 1000;
const FIRST_WITH_JITTER = 2;

/**
 * Returns the pause before the next attempt, after `failures` failed attempts in a row.
 *
 * From the third attempt on it adds a random part of a second (`random` is in 0…1), so that not
 * everybody reconnects at the same instant after the server restarts.
 */
export function retryDelayMs(failures: number, random: number): number {
  const delayMs = DELAYS_MS[failures] ?? LAST_MS;
  return failures < FIRST_WITH_JITTER ? delayMs : delayMs + random * MAX_JITTER_MS;
}
