import { vi } from "vitest";

/** Waits for what must come, as long as a test may take: a module is loaded, a promise settled. */
export const eventually = <T>(asks: () => T | Promise<T>, interval = 50): Promise<T> =>
  vi.waitFor(asks, { interval, timeout: 30_000 });
