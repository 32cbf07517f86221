import { wayInForce } from "../../drive/drivePreferences";
import { DIRECTIONS } from "../../drive/inputState";
import { DEFAULT_KEYS, type KeyAction, type KeyMap, keyWords } from "../../drive/keyMap";
import type { Hello } from "../../messages";
import type { Preferences } from "../../preferences";
import { type Code, t } from "../../words/words";

/** A key's label, or its name. */
export function keyName(key: string): string {
  return key === "Space" ? t("ways.key_space") : keyWords(key);
}

/** How to drive with this user's keys, in one sentence; actions without a key are left out. */
export function keyHint(preferences: Preferences, hello: Hello | null): string {
  const { keys } = preferences;
  const isScanning = wayInForce(preferences, hello?.click_to_move) === "scan";
  const one = (code: Code, action: KeyAction, isThere = true) => {
    const key = keys[action][0];
    return isThere && key !== undefined ? [t(code, { key: keyName(key) })] : [];
  };
  const drive = directionKeys(keys);
  const parts = [
    ...one("ways.hint_choose", "scan_select", isScanning),
    ...one("ways.hint_next", "scan_next", isScanning && preferences.switches === 2),
    ...(drive && !isScanning ? [t("ways.hint_drive", { keys: drive })] : []),
    ...one("ways.hint_talk", "talk", hello?.voice != null),
    ...one("ways.hint_cameras", "cameras", (hello?.cameras.length ?? 0) > 0),
    ...one("ways.hint_stop", "stop"),
  ];
  return t("ways.hint", { parts: parts.join(", ") });
}

/** The keys of all four directions; empty if one of them has none. */
function directionKeys(keys: KeyMap): string {
  if (DIRECTIONS.every((one) => keys[one].join() === DEFAULT_KEYS[one].join()))
    return t("ways.hint_default_keys");
  const first = DIRECTIONS.flatMap((one) => keys[one].slice(0, 1));
  return first.length === DIRECTIONS.length ? first.map(keyName).join(" ") : "";
}
