import { expect, it } from "vitest";
import { DRIVE_DEFAULTS, loadDrivePreferences, wayInForce } from "./drivePreferences";

it("finds again what was saved", () => {
  const mine = {
    ...DRIVE_DEFAULTS,
    way: "scan",
    stepMs: 1000,
    switches: 2,
    dwellMs: 500,
    gamepad: { turn: "right", triggers: false, deadZone: 0.5, curve: 3 },
  } as const;
  expect(loadDrivePreferences(JSON.parse(JSON.stringify(mine)))).toEqual(mine);
});

it.each([
  {},
  { way: "fly", stepMs: 100_000, switches: 3, dwellMs: "1", keys: 7, gamepad: null },
  { stepMs: 0, gamepad: { turn: 1, triggers: 1, deadZone: 0, curve: Number.NaN } },
  { gamepad: "Xbox" },
])("takes the defaults for what is missing or invalid: %j", (kept) => {
  expect(loadDrivePreferences(kept)).toEqual(DRIVE_DEFAULTS);
});

it.each([
  ["click", false, "hold"],
  ["click", undefined, "hold"],
  ["click", true, "click"],
  ["step", false, "step"],
] as const)("%s is in force only where the host allows it: %s", (way, may, inForce) => {
  expect(wayInForce({ ...DRIVE_DEFAULTS, way }, may)).toBe(inForce);
});
