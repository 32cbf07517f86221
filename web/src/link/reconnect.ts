/** When to try again after a connection was lost: soon, then ever less eagerly. */

const DELAYS_MS = [0, 300, 1200, 2700, 4800, 7000] as const;
const LAST_MS = 7000;
const MAX_JITTER_MS = 1000;
const FIRST_WITH_JITTER = 2;

/**
 * The pause before the next attempt, after `failures` attempts in a row that came to nothing.
 *
 * From the third attempt on a random part of a second is added (`random` is in 0…1), so that
 * everybody whom a restart of the server threw out does not come back at the same instant.
 */
export function retryDelayMs(failures: number, random: number): number {
  const delayMs = DELAYS_MS[failures] ?? LAST_MS;
  return failures < FIRST_WITH_JITTER ? delayMs : delayMs + random * MAX_JITTER_MS;
}
