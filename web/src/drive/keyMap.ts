/** Which key does what, by its position on the keyboard, else by its name (`codeOf`). Pure. */

export const KEY_ACTIONS = [
  "forward",
  "back",
  "left",
  "right",
  "lateral_left",
  "lateral_right",
  "stop",
  "speed",
  "axis1_plus",
  "axis1_minus",
  "axis2_plus",
  "axis2_minus",
  "recentre",
  "talk",
  "cameras",
  "mute",
  "scan_select",
  "scan_next",
] as const;
export type KeyAction = (typeof KEY_ACTIONS)[number];
export type KeyMap = Readonly<Record<KeyAction, readonly string[]>>;

/** On a French keyboard W A S D are Z Q S D. Left and up are an axis's positive ends. */
export const DEFAULT_KEYS: KeyMap = {
  forward: ["ArrowUp", "KeyW"],
  back: ["ArrowDown", "KeyS"],
  left: ["ArrowLeft", "KeyA"],
  right: ["ArrowRight", "KeyD"],
  lateral_left: ["KeyQ", "Shift+ArrowLeft"],
  lateral_right: ["KeyE", "Shift+ArrowRight"],
  stop: ["Space"],
  speed: ["KeyF"],
  axis1_plus: ["KeyJ"],
  axis1_minus: ["KeyL"],
  axis2_plus: ["KeyI"],
  axis2_minus: ["KeyK"],
  recentre: ["KeyO"],
  talk: ["KeyT"],
  cameras: ["KeyC"],
  mute: ["KeyM"],
  scan_select: ["Enter", "NumpadEnter"],
  scan_next: ["KeyN"],
};

/** Space stops on every device, so that nobody has to ask which key it is. */
export const ALWAYS_STOP = "Space";
export const MOST_PER_ACTION = 4;
/** Before a key that is pressed with Shift. */
export const SHIFT = "Shift+";
const CODE = /^[A-Za-z0-9]{1,24}$/;
/** Keys that the browser, the system or a screen reader needs. */
const RESERVED =
  /^(Tab|Escape|CapsLock|Fn.*|Unidentified|(Control|Alt|AltGraph|Meta|OS|Shift)(Left|Right)?)$/;

/**
 * What a key does. With Shift it does what it does alone, unless it has an action of its own there;
 * a key for Stop always stops.
 */
export function actionOf(keys: KeyMap, key: string, isShifted = false): KeyAction | null {
  const action = KEY_ACTIONS.find((one) => keys[one].includes(key)) ?? null;
  if (!isShifted || action === "stop") return action;
  return actionOf(keys, SHIFT + key) ?? action;
}

/** The keys as they work on a robot: only one that moves sideways takes those for that. */
export function keysInForce(keys: KeyMap, movesSideways: boolean): KeyMap {
  return movesSideways ? keys : { ...keys, lateral_left: [], lateral_right: [] };
}

/** The key itself, of one that is perhaps pressed with Shift. */
export function withoutShift(key: string): string {
  return key.startsWith(SHIFT) ? key.slice(SHIFT.length) : key;
}

/** Returns the stored keys as far as they are valid, with the defaults for every other action. */
export function loadKeys(kept: unknown): KeyMap {
  const stored: Record<string, unknown> = { ...(typeof kept === "object" ? kept : null) };
  const used = new Set([ALWAYS_STOP]);
  const take = (codes: readonly unknown[]) => {
    const taken = new Set<string>();
    for (const code of codes) {
      if (typeof code !== "string" || !isUsable(code) || used.has(code)) continue;
      if (taken.size >= MOST_PER_ACTION) break;
      taken.add(code);
      used.add(code);
    }
    return [...taken];
  };
  const keys: Record<KeyAction, readonly string[]> = { ...DEFAULT_KEYS };
  const isStored = (action: KeyAction) => Array.isArray(stored[action]);
  for (const action of KEY_ACTIONS) {
    if (isStored(action)) keys[action] = take(stored[action] as unknown[]);
  }
  for (const action of KEY_ACTIONS) {
    if (!isStored(action)) keys[action] = take(DEFAULT_KEYS[action]);
  }
  return { ...keys, stop: [ALWAYS_STOP, ...keys.stop] };
}

export function isUsable(key: string): boolean {
  const alone = withoutShift(key);
  return CODE.test(alone) && !RESERVED.test(alone);
}
