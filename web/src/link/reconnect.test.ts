import { expect, it } from "vitest";
import { retryDelayMs } from "./reconnect";

it("tries at once, then waits longer each time, never longer than eight seconds", () => {
  const delays = [0, 1, 2, 3, 4, 5, 6, 100].map((failures) => retryDelayMs(failures, 0));
  expect(delays).toEqual([0, 300, 1200, 2700, 4800, 7000, 7000, 7000]);
});

it("adds up to a second of chance from the third attempt on", () => {
  expect([0, 1, 2, 6].map((failures) => retryDelayMs(failures, 1))).toEqual([0, 300, 2200, 8000]);
});
