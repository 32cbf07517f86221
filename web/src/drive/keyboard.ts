/** Whether a key drives or is for the focused element; what it does: `keyActions.ts`. */

import { codeOf } from "./codeOf";
import { DIRECTIONS } from "./inputState";
import { actionOf, type KeyAction, type KeyMap } from "./keyMap";
import { holderOf, KeysDown } from "./keysDown";

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox])";
const OPERABLE = `${TYPING}, button, a[href], summary, input`;
/** Keys that operate the focused element. */
const OPERATING = new Set(["Space", "Enter", "NumpadEnter"]);

export interface KeyboardOptions {
  keys: () => KeyMap;
  isDriving: () => boolean;
  /** Whether this action is handled here now. */
  isFor: (action: KeyAction) => boolean;
  /** Starts the action; it lasts until `release` of the same holder. */
  press: (holder: string, action: KeyAction) => void;
  release: (holder: string) => void;
  /** A key was pressed that nothing else on the page has handled. */
  anyKey: () => void;
  /** Releases everything at once. */
  letGo: () => void;
  signal: AbortSignal;
}

/** Performs the actions of the user's keys, unless a text field has the focus. */
export function listenKeyboard(target: EventTarget, options: KeyboardOptions): void {
  const { keys, isDriving, isFor, press, release, anyKey, letGo, signal } = options;
  const down = new KeysDown(release);
  const taken = new Set<string>();

  const isHeld = () =>
    down.names.some((code) =>
      [false, true].some((isShifted) => {
        const action = actionOf(keys(), code, isShifted);
        return DIRECTIONS.some((one) => one === action);
      }),
    );

  const onDown = (event: KeyboardEvent) => {
    const code = codeOf(event);
    const isKnown = down.has(event);
    const isNew = down.press(event);
    if (event.ctrlKey || event.metaKey || event.altKey) {
      // macOS sends no keyup while Meta is down.
      letGo();
      return;
    }
    if (event.defaultPrevented || !isDriving()) return;
    if (isNew) anyKey();
    const action = actionOf(keys(), code, event.shiftKey);
    if (action === null || !isFor(action)) return;
    const focus = event.target instanceof Element ? event.target : null;
    // While keys drive, Space means Stop, whatever has the focus.
    const isButtons = OPERATING.has(code) && !(action === "stop" && isHeld());
    if (focus?.closest(isButtons ? OPERABLE : TYPING)) return;
    event.preventDefault();
    taken.add(holderOf(event));
    // If a release was lost, the next Space must still stop.
    const isStop = action === "stop" && !(event.repeat && isKnown);
    if (isNew || isStop) press(holderOf(event), action);
  };

  const onUp = (event: KeyboardEvent) => {
    down.lift(event);
    // Firefox clicks a button on keyup.
    if (taken.delete(holderOf(event))) event.preventDefault();
  };

  const listening = { signal };
  target.addEventListener("keydown", onDown as EventListener, listening);
  target.addEventListener("keyup", onUp as EventListener, listening);
  target.addEventListener(
    "blur",
    () => {
      down.clear();
      taken.clear();
    },
    listening,
  );
}
