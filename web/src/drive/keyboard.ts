import { codeOf } from "./codeOf";
import { DIRECTIONS } from "./inputState";
import { actionOf, type KeyAction, type KeyMap } from "./keyMap";

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox])";
const OPERABLE = `${TYPING}, button, a[href], summary, input`;
/** Keys that operate what has the focus. */
const OPERATING = new Set(["Space", "Enter", "NumpadEnter"]);

export interface KeyboardOptions {
  keys: () => KeyMap;
  isDriving: () => boolean;
  /** Whether this action is done here, and now. */
  isFor: (action: KeyAction) => boolean;
  /** Does it, until `release` of the same holder. */
  press: (holder: string, action: KeyAction) => void;
  release: (holder: string) => void;
  /** A key was pressed that nothing on the page has taken for itself. */
  anyKey: () => void;
  /** Releases everything at once. */
  letGo: () => void;
  signal: AbortSignal;
}

/** Drives, stops and more by the user's keys, unless a text field has the focus. */
export function listenKeyboard(target: EventTarget, options: KeyboardOptions): void {
  const { keys, isDriving, isFor, press, release, anyKey, letGo, signal } = options;
  // Not every browser marks repeated keys as such after the window lost the focus.
  const down = new Set<string>();
  const taken = new Set<string>();

  const isHeld = () =>
    [...down].some((code) => DIRECTIONS.some((one) => one === actionOf(keys(), code)));

  const onDown = (event: KeyboardEvent) => {
    const code = codeOf(event);
    const repeated = event.repeat || down.has(code);
    down.add(code);
    if (event.ctrlKey || event.metaKey || event.altKey) {
      // macOS sends no keyup while Meta is down.
      letGo();
      return;
    }
    if (event.defaultPrevented || !isDriving()) return;
    if (!repeated) anyKey();
    const action = actionOf(keys(), code);
    if (action === null || !isFor(action)) return;
    const focus = event.target instanceof Element ? event.target : null;
    // Whoever drives by keys means the robot by Space, whatever they have chosen before.
    const isButtons = OPERATING.has(code) && !(action === "stop" && isHeld());
    if (focus?.closest(isButtons ? OPERABLE : TYPING)) return;
    event.preventDefault();
    taken.add(code);
    if (!repeated) press(`key ${code}`, action);
  };

  const onUp = (event: KeyboardEvent) => {
    const code = codeOf(event);
    down.delete(code);
    // Firefox presses a button when the key comes up.
    if (taken.delete(code)) event.preventDefault();
    release(`key ${code}`);
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
