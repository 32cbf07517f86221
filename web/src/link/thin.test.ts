import { expect, it } from "vitest";
import { cameOverThin, isNeededForDriving, isThin } from "./thin";

it("counts a link below 100 kbit/s as thin", () => {
  expect(isThin({ link_bps: 99_999 })).toBe(true);
  expect(isThin({ link_bps: 100_000 })).toBe(false);
});

it.each([
  [60_000, 4000, false],
  [60_000, 6000, true],
  [2000, 6000, false], // of the round trip, not of the rate
  [0, 6000, false], // from the browser's cache
])("knows by %d bytes in %d ms whether the page came over a thin link", (transferSize, ms, is) => {
  expect(cameOverThin([{ transferSize, responseStart: 100, responseEnd: 100 + ms }])).toBe(is);
});

it("reserves a thin or unknown link for driving", () => {
  expect(isNeededForDriving({ link_bps: 48_000 }, 7)).toBe(true);
  expect(isNeededForDriving(null, 7)).toBe(true);
  expect(isNeededForDriving({ link_bps: 2_000_000 }, 7)).toBe(false);
  expect(isNeededForDriving({ link_bps: 48_000 }, null)).toBe(false);
});
