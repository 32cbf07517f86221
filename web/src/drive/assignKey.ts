/** Changes which key does what, within the rules for keys. Pure. */

import {
  ALWAYS_STOP,
  actionOf,
  isUsable,
  type KeyAction,
  type KeyMap,
  MOST_PER_ACTION,
} from "./keyMap";

/** Why a key cannot be assigned; `by` is the action that has it. */
export type Refusal =
  | { why: "reserved" | "too_many" | "always_stops" }
  | { why: "taken"; by: KeyAction };
export type Assigned = { keys: KeyMap } | Refusal;

/** Adds a key to an action, or says why that is refused. */
export function assign(keys: KeyMap, action: KeyAction, key: string): Assigned {
  if (!isUsable(key)) return { why: "reserved" };
  const by = actionOf(keys, key);
  if (by === action) return { keys };
  if (by !== null) return { why: "taken", by };
  if (keys[action].length >= MOST_PER_ACTION) return { why: "too_many" };
  return { keys: { ...keys, [action]: [...keys[action], key] } };
}

/** Takes a key away from an action, but not Space from Stop. */
export function unassign(keys: KeyMap, action: KeyAction, key: string): Assigned {
  if (key === ALWAYS_STOP) return { why: "always_stops" };
  return { keys: { ...keys, [action]: keys[action].filter((one) => one !== key) } };
}
