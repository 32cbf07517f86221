/** Changes which key does what, within the rules for keys. Pure. */

import {
  ALWAYS_STOP,
  actionOf,
  isUsable,
  KEY_ACTIONS,
  type KeyAction,
  type KeyMap,
  MOST_PER_ACTION,
  withoutShift,
} from "./keyMap";

/** Why a key cannot be assigned; `by` is the action that has it. */
export type Refusal =
  | { why: "reserved" | "too_many" | "always_stops" }
  | { why: "taken"; by: KeyAction };
export type Assigned = { keys: KeyMap } | Refusal;

/**
 * Adds a key to an action, or says why that is refused. An action that is not shown has no effect
 * on this robot, and gives its key up.
 */
export function assign(
  keys: KeyMap,
  action: KeyAction,
  key: string,
  shown: readonly KeyAction[] = KEY_ACTIONS,
): Assigned {
  if (!isUsable(key)) return { why: "reserved" };
  const by = keys.stop.includes(withoutShift(key)) ? "stop" : actionOf(keys, key);
  if (by === action) return { keys };
  if (by !== null && shown.includes(by)) return { why: "taken", by };
  if (keys[action].length >= MOST_PER_ACTION) return { why: "too_many" };
  const others = by === null ? keys : { ...keys, [by]: keys[by].filter((one) => one !== key) };
  return { keys: { ...others, [action]: [...keys[action], key] } };
}

/** Takes a key away from an action, but not Space from Stop. */
export function unassign(keys: KeyMap, action: KeyAction, key: string): Assigned {
  if (key === ALWAYS_STOP) return { why: "always_stops" };
  return { keys: { ...keys, [action]: keys[action].filter((one) => one !== key) } };
}
