import { expect, it } from "vitest";
import { isNeededForDriving, isThin } from "./thin";

it("takes a link below 100 kbit/s for a thin one", () => {
  expect(isThin({ link_bps: 99_999 })).toBe(true);
  expect(isThin({ link_bps: 100_000 })).toBe(false);
});

it("keeps a thin link, or one of which nothing is known, for whoever drives", () => {
  expect(isNeededForDriving({ link_bps: 48_000 }, 7)).toBe(true);
  expect(isNeededForDriving(null, 7)).toBe(true);
  expect(isNeededForDriving({ link_bps: 2_000_000 }, 7)).toBe(false);
  expect(isNeededForDriving({ link_bps: 48_000 }, null)).toBe(false);
});
