import { expect, it, vi } from "vitest";
import { measureRefresh } from "./refresh";

it("finds the refresh interval although the page is sometimes busy", async () => {
  let frame = 0;
  let nowMs = 500;
  vi.stubGlobal("requestAnimationFrame", (callback: FrameRequestCallback) => {
    nowMs += frame++ % 5 === 0 ? 90 : 1000 / 120;
    queueMicrotask(() => callback(nowMs));
  });
  expect(await measureRefresh()).toBeCloseTo(1000 / 120);
  expect(frame).toBeLessThan(50);
});
