import { beforeEach, expect, it, vi } from "vitest";
import { Unsettled, within } from "./within";
import { said } from "./words/said";

beforeEach(() => {
  vi.useFakeTimers();
});

it("settles as the browser does", async () => {
  expect(await within("getStats", Promise.resolve(7))).toBe(7);
  await expect(within("getStats", Promise.reject(new TypeError("no")))).rejects.toThrow("no");
  expect(vi.getTimerCount()).toBe(0);
});

it("names what the browser leaves pending for 4 s", async () => {
  const failed = vi.fn();
  void within("getStats", new Promise(() => {})).catch(failed);
  await vi.advanceTimersByTimeAsync(3999);
  expect(failed).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(1);
  const why = failed.mock.lastCall?.[0] as Unsettled;
  expect(why).toBeInstanceOf(Unsettled);
  expect(said(why.saying)).toContain("Your browser does not answer (getStats).");
});
