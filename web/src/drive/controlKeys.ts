/** Which of the robot's controls a key presses; keys that drive: `keyboard.ts`. */

import type { ControlInfo } from "../messages";
import { isOwnPress } from "../typing";
import { codeOf } from "./codeOf";
import { actionOf, type KeyMap } from "./keyMap";
import { holderOf, KeysDown } from "./keysDown";
import type { Operating } from "./operating";

export interface ControlKeysOptions {
  operating: Operating;
  controls: () => readonly ControlInfo[];
  keys: () => KeyMap;
  signal: AbortSignal;
}

/** Presses buttons and toggles by the host's keys, except keys that the user has assigned. */
export function listenControlKeys(target: EventTarget, options: ControlKeysOptions): void {
  const { operating, controls, keys, signal } = options;
  const down = new KeysDown((holder) => void operating.release(holder));
  const onDown = (event: KeyboardEvent) => {
    down.press(event);
    const control = controlOf(controls(), keys(), codeOf(event), event.shiftKey);
    if (!control || event.defaultPrevented || !isOwnPress(event)) return;
    event.preventDefault();
    if (control.kind === "button") operating.press(holderOf(event), control.name);
    else operating.toggle(control.name);
  };
  target.addEventListener("keydown", onDown as EventListener, { signal });
  const onUp = (event: KeyboardEvent) => down.lift(event);
  target.addEventListener("keyup", onUp as EventListener, { signal });
  target.addEventListener("blur", () => down.clear(), { signal });
}

/** Returns the control that this key presses; none if the user has assigned the key. */
export function controlOf(
  controls: readonly ControlInfo[],
  keys: KeyMap,
  key: string,
  isShifted = false,
): ControlInfo | undefined {
  const isFree = actionOf(keys, key, isShifted) === null;
  return isFree ? controls.find((one) => one.key === key) : undefined;
}
