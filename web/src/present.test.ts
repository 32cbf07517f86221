import { readFileSync } from "node:fs";
import { expect, it, vi } from "vitest";

it("shows a proxy four times a minute that its user is still signed in", async () => {
  vi.useFakeTimers();
  const asked = vi.fn(async (_path: string, _init: RequestInit) => {
    throw new TypeError("the proxy does not answer");
  });
  const source = readFileSync(`${import.meta.dirname}/../public/present.js`, "utf8");
  new Function("fetch", source)(asked);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(4);
  expect(asked).toHaveBeenCalledWith("api/present", { redirect: "manual" });
  vi.useRealTimers();
});
