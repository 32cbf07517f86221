/** How this user drives on this device. Pure. */

import { DEFAULT_KEYS, type KeyMap, loadKeys } from "./keyMap";
import { loadLearnt, MOST_PADS, MOST_PARTS } from "./learntParts";
import type { PadSettings } from "./padReading";
import { WAYS, type Way } from "./ways";

export interface DrivePreferences {
  way: Way;
  /** What is on the screen; null for what suits the pointer: a stick for fingers, else buttons. */
  control: Control | null;
  /** How long a step moves. */
  stepMs: number;
  /** How many switches the user scans with. */
  switches: 1 | 2;
  /** With one switch, how long each thing is offered. */
  dwellMs: number;
  keys: KeyMap;
  gamepad: PadSettings;
}

export type Control = "stick" | "buttons";
export const CONTROLS = [null, "stick", "buttons"] as const;

/** The range and step of each number that the user can set. */
export const RANGES = {
  stepMs: { min: 200, max: 1000, step: 100 },
  dwellMs: { min: 500, max: 5000, step: 250 },
  deadZone: { min: 0.05, max: 0.5, step: 0.05 },
  curve: { min: 1, max: 3, step: 0.25 },
} as const;

export const DRIVE_DEFAULTS: DrivePreferences = {
  way: "hold",
  control: null,
  stepMs: 400,
  switches: 1,
  dwellMs: 1500,
  keys: DEFAULT_KEYS,
  gamepad: {
    turn: "left",
    planarTurn: "right",
    triggers: true,
    deadZone: 0.15,
    curve: 1.5,
    rests: {},
    learnt: {},
  },
};

/** Returns the stored choices, with defaults for missing or invalid ones. */
export function loadDrivePreferences(kept: Readonly<Record<string, unknown>>): DrivePreferences {
  const of = DRIVE_DEFAULTS;
  const pad: Record<string, unknown> = {
    ...(typeof kept.gamepad === "object" ? kept.gamepad : null),
  };
  return {
    way: WAYS.find((one) => one === kept.way) ?? of.way,
    control: CONTROLS.find((one) => one === kept.control) ?? of.control,
    stepMs: ranged(kept.stepMs, RANGES.stepMs) ?? of.stepMs,
    switches: kept.switches === 2 ? 2 : of.switches,
    dwellMs: ranged(kept.dwellMs, RANGES.dwellMs) ?? of.dwellMs,
    keys: loadKeys(kept.keys),
    gamepad: {
      turn: pad.turn === "right" ? "right" : of.gamepad.turn,
      planarTurn: pad.planarTurn === "left" ? "left" : of.gamepad.planarTurn,
      triggers: typeof pad.triggers === "boolean" ? pad.triggers : of.gamepad.triggers,
      deadZone: ranged(pad.deadZone, RANGES.deadZone) ?? of.gamepad.deadZone,
      curve: ranged(pad.curve, RANGES.curve) ?? of.gamepad.curve,
      rests: loadRests(pad.rests),
      learnt: loadLearnt(pad.learnt),
    },
  };
}

/** The control on the screen; a stick works only with the way `hold`. */
export function controlInForce(
  preferences: DrivePreferences,
  way: Way,
  isCoarse: boolean,
): Control {
  if (way !== "hold") return "buttons";
  return preferences.control ?? (isCoarse ? "stick" : "buttons");
}

/** The way in force: clicks only where the host allows them. */
export function wayInForce({ way }: DrivePreferences, mayClick: boolean | undefined): Way {
  return way === "click" && !mayClick ? "hold" : way;
}

const REST = { min: -1, max: 1 };

function loadRests(kept: unknown): PadSettings["rests"] {
  const isRests = (rests: unknown) =>
    Array.isArray(rests) &&
    rests.length <= MOST_PARTS &&
    rests.every((one) => ranged(one, REST) !== null);
  const all = Object.entries(typeof kept === "object" && kept !== null ? kept : {});
  return Object.fromEntries(all.filter(([, rests]) => isRests(rests)).slice(-MOST_PADS));
}

function ranged(value: unknown, { min, max }: { min: number; max: number }): number | null {
  return typeof value === "number" && value >= min && value <= max ? value : null;
}
