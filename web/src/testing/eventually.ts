import { vi } from "vitest";

/** Waits until `asks` succeeds, at most as long as a test may take. */
export const eventually = <T>(asks: () => T | Promise<T>, interval = 50): Promise<T> =>
  vi.waitFor(asks, { interval, timeout: 30_000 });
