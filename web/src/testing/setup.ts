/**
 * For every test: all words are there, as soon after the page's first picture, and nothing is of
 * the test or the file before it.
 */
import { afterAll, afterEach, vi } from "vitest";
import { all } from "../words/en";
import { loadSaid } from "../words/said";
import { learn } from "../words/words";

learn(all);
await loadSaid();

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

afterAll(async () => {
  vi.resetModules();
  await globalThis.renewWindow?.();
});
