import { wayInForce } from "../../drive/drivePreferences";
import type { Direction } from "../../drive/inputState";
import { keyWords } from "../../drive/keyCaps";
import { DEFAULT_KEYS, type KeyAction, type KeyMap, SHIFT, withoutShift } from "../../drive/keyMap";
import type { Hello } from "../../messages";
import type { Preferences } from "../../preferences";
import { type Code, t } from "../../words/words";

/** A key's label, or its name. */
export function keyName(key: string): string {
  if (key === "Space") return t("ways.key_space");
  if (!key.startsWith(SHIFT)) return keyWords(key);
  return t("ways.key_shift", { key: keyName(withoutShift(key)) });
}

/** How to drive with the keys in force, in one sentence; actions without a key are left out. */
export function keyHint(preferences: Preferences, keys: KeyMap, hello: Hello | null): string {
  const isScanning = wayInForce(preferences, hello?.click_to_move) === "scan";
  const one = (code: Code, action: KeyAction, isThere = true) => {
    const key = keys[action][0];
    return isThere && key !== undefined ? [t(code, { key: keyName(key) })] : [];
  };
  const drive = isDefault(keys)
    ? t("ways.hint_default_keys", { keys: LETTERS.map(keyName).join(" ") })
    : firstKeys(keys, DRIVING);
  const sideways = firstKeys(keys, SIDEWAYS);
  const parts = [
    ...one("ways.hint_choose", "scan_select", isScanning),
    ...one("ways.hint_next", "scan_next", isScanning && preferences.switches === 2),
    ...(drive && !isScanning ? [t("ways.hint_drive", { keys: drive })] : []),
    ...(sideways && !isScanning ? [t("ways.hint_sideways", { keys: sideways })] : []),
    ...one("ways.hint_talk", "talk", hello?.voice != null),
    ...one("ways.hint_cameras", "cameras", (hello?.cameras.length ?? 0) > 0),
    ...one("ways.hint_stop", "stop"),
  ];
  return t("ways.hint", { parts: parts.join(", ") });
}

/** Of the default keys, in the order in which people name them. */
const LETTERS = ["KeyW", "KeyA", "KeyS", "KeyD"];
const DRIVING: readonly Direction[] = ["forward", "back", "left", "right"];
const SIDEWAYS: readonly Direction[] = ["lateral_left", "lateral_right"];

function isDefault(keys: KeyMap): boolean {
  return DRIVING.every((one) => keys[one].join() === DEFAULT_KEYS[one].join());
}

/** The keys of all these directions; empty if one of them has none. */
function firstKeys(keys: KeyMap, of: readonly Direction[]): string {
  const first = of.flatMap((one) => keys[one].slice(0, 1));
  return first.length === of.length ? first.map(keyName).join(" ") : "";
}
