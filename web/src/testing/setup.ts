/**
 * For every test: all words are loaded, as they are soon after the first picture, and nothing is
 * left over from the previous test or file.
 */
import { afterAll, afterEach, vi } from "vitest";
import { all } from "../words/en";
import { loadSaid } from "../words/said";
import { addEnglish } from "../words/words";

addEnglish(all);
await loadSaid();

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

afterAll(async () => {
  vi.resetModules();
  await globalThis.renewWindow?.();
});
