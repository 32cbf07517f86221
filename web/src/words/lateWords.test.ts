import { beforeEach, expect, it, vi } from "vitest";
import { LateWords } from "./lateWords";

beforeEach(() => {
  vi.useFakeTimers();
});

it("loads once, however often it is called", () => {
  const load = vi.fn(async () => {});
  const words = new LateWords(load);
  expect(load).not.toHaveBeenCalled();
  void words.loadOnce();
  void words.loadOnce();
  expect(load).toHaveBeenCalledOnce();
});

it("resolves when it has loaded, or could not", async () => {
  const load = vi.fn(async () => {});
  load.mockRejectedValueOnce(new Error("the server is gone"));
  const words = new LateWords(load);
  await expect(words.loadOnce()).resolves.toBeUndefined();
  await vi.advanceTimersByTimeAsync(5000);
  await expect(words.loadOnce()).resolves.toBeUndefined();
  expect(load).toHaveBeenCalledTimes(2);
});

it("retries until it has loaded", async () => {
  const load = vi.fn(async () => {});
  load.mockRejectedValueOnce(new Error("the server is gone"));
  const words = new LateWords(load);
  void words.loadOnce();
  await vi.advanceTimersByTimeAsync(5000);
  expect(load).toHaveBeenCalledTimes(2);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(load).toHaveBeenCalledTimes(2);
});
