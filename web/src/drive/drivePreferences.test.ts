import { expect, it } from "vitest";
import { DRIVE_DEFAULTS, loadDrivePreferences, wayInForce } from "./drivePreferences";

const LONG = Array.from({ length: 65 }, () => 0);

it("restores what was saved", () => {
  const mine = {
    ...DRIVE_DEFAULTS,
    way: "scan",
    stepMs: 1000,
    switches: 2,
    dwellMs: 500,
    gamepad: {
      turn: "right",
      planarTurn: "left",
      triggers: false,
      deadZone: 0.5,
      curve: 3,
      rests: { Stick: [0, -1, 0] },
      learnt: {},
    },
  } as const;
  expect(loadDrivePreferences(JSON.parse(JSON.stringify(mine)))).toEqual(mine);
});

it.each([
  {},
  { way: "fly", stepMs: 100_000, switches: 3, dwellMs: "1", keys: 7, gamepad: null },
  {
    stepMs: 0,
    gamepad: { turn: 1, planarTurn: "up", triggers: 1, deadZone: 0, curve: Number.NaN },
  },
  { gamepad: "Xbox" },
  { gamepad: { rests: "Stick" } },
  { gamepad: { rests: { a: null, b: ["0"], c: [0, 0, 1.1], d: [0, 0, null], e: LONG } } },
])("takes the defaults for what is missing or invalid: %j", (kept) => {
  expect(loadDrivePreferences(kept)).toEqual(DRIVE_DEFAULTS);
});

it("keeps what gamepads were taught", () => {
  const learnt = { Stick: { ahead: { kind: "axis", at: 5, to: 1 } } };
  expect(loadDrivePreferences({ gamepad: { learnt } }).gamepad.learnt).toEqual(learnt);
});

it("keeps the rests of the eight newest gamepads", () => {
  const all = Array.from({ length: 9 }, (_, at) => [`Stick ${at}`, [0, at / 10, 0]]);
  const { rests } = loadDrivePreferences({ gamepad: { rests: Object.fromEntries(all) } }).gamepad;
  expect(Object.entries(rests)).toEqual(all.slice(1));
});

it.each([
  ["click", false, "hold"],
  ["click", undefined, "hold"],
  ["click", true, "click"],
  ["step", false, "step"],
] as const)("%s is in force only where the host allows it: %s", (way, may, inForce) => {
  expect(wayInForce({ ...DRIVE_DEFAULTS, way }, may)).toBe(inForce);
});
