import { useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";
import { type Assigned, assign, unassign } from "../../drive/assignKey";
import { keyedAxes } from "../../drive/axisKeys";
import { codeOf } from "../../drive/codeOf";
import { wayInForce } from "../../drive/drivePreferences";
import { DEFAULT_KEYS, isUsable, KEY_ACTIONS, type KeyAction, SHIFT } from "../../drive/keyMap";
import { t } from "../../words/words";
import { useActions, useState } from "../context";
import { directionNames } from "../directionNames";
import { keyName } from "./keyHint";
import { ACTION_NAMES, REFUSALS } from "./names";

/** Which key does what; a new one is chosen by pressing it. */
export function KeyChoice() {
  const { preferences, drivingTurn, movesSideways } = useState();
  const { setDriving, stop } = useActions();
  const awaited = useSignal<KeyAction | null>(null);
  const complaint = useSignal("");
  const { keys } = preferences.value;
  const names = { ...ACTION_NAMES, ...directionNames(movesSideways.value) };
  const name = (action: KeyAction) => t(names[action]);
  const shown = useActionsShown();

  const change = (changed: Assigned, action: KeyAction, key: string) => {
    awaited.value = null;
    complaint.value = "";
    if ("keys" in changed) setDriving({ keys: changed.keys });
    else {
      const of = changed.why === "taken" ? changed.by : action;
      complaint.value = t(REFUSALS[changed.why], { key: keyName(key), action: name(of) });
    }
  };

  const action = awaited.value;
  // A layout effect, so that it listens exactly while it says so, not some frames later.
  useLayoutEffect(() => {
    if (action === null) return;
    const ending = new AbortController();
    const onKey = (event: KeyboardEvent) => {
      // The key is only for this choice.
      event.preventDefault();
      event.stopImmediatePropagation();
      const code = codeOf(event);
      // Ignore an event that identifies no key, as an input method's.
      if (event.repeat || code === "") return;
      const isShifted = movesSideways.peek() && event.shiftKey && code !== "Space";
      // The key to be pressed with it is still to come.
      if (isShifted && /^Shift/.test(code)) return;
      const key = isShifted && isUsable(code) ? SHIFT + code : code;
      if (code === "Space" && drivingTurn.peek() !== null) stop();
      if (code === "Escape") awaited.value = null;
      else change(assign(preferences.peek().keys, action, key, shown), action, key);
    };
    window.addEventListener("keydown", onKey, { capture: true, signal: ending.signal });
    const onBlur = () => {
      awaited.value = null;
    };
    window.addEventListener("blur", onBlur, { signal: ending.signal });
    return () => ending.abort();
  }, [action]);

  return (
    <fieldset class="ways-group">
      <legend>{t("ways.keys")}</legend>
      <ul class="ways-keys">
        {shown.map((one) => (
          <li key={one}>
            <span>{name(one)}</span>
            {keys[one].map((key) => (
              <button
                key={key}
                type="button"
                class="key-cap"
                aria-label={t("ways.keys_remove", { key: keyName(key), action: name(one) })}
                onClick={(event) => {
                  const changed = unassign(keys, one, key);
                  // Keyboard users continue from here, but this button is about to be removed.
                  if (event.detail === 0 && "keys" in changed) focusNext(event.currentTarget);
                  change(changed, one, key);
                }}
              >
                <kbd>{keyName(key)}</kbd> <span aria-hidden="true">×</span>
              </button>
            ))}
            <button
              type="button"
              class="key-cap"
              aria-label={t("ways.keys_add", { action: name(one) })}
              aria-pressed={action === one}
              onClick={() => {
                complaint.value = "";
                awaited.value = action === one ? null : one;
              }}
            >
              +
            </button>
          </li>
        ))}
      </ul>
      <p class="ways-told" aria-live="polite">
        {action === null ? complaint.value : t("ways.keys_press", { action: name(action) })}
      </p>
      <button
        type="button"
        onClick={() => {
          complaint.value = "";
          setDriving({ keys: DEFAULT_KEYS });
        }}
      >
        {t("ways.keys_reset")}
      </button>
    </fieldset>
  );
}

/** Focuses the key after this one, or the button that adds one. */
function focusNext(button: HTMLElement): void {
  const next = button.nextElementSibling;
  if (next instanceof HTMLElement) next.focus();
}

/** The actions that have an effect on this robot with this user's way of driving. */
function useActionsShown(): KeyAction[] {
  const { hello, preferences, movesSideways } = useState();
  const [first, second] = keyedAxes(hello.value?.robot.axes ?? []);
  const isScanning = wayInForce(preferences.value, hello.value?.click_to_move) === "scan";
  return KEY_ACTIONS.filter((action) => {
    if (action.startsWith("axis1")) return first !== undefined;
    if (action.startsWith("axis2")) return second !== undefined;
    if (action.startsWith("scan")) return isScanning;
    if (action === "recentre") return first !== undefined || second !== undefined;
    if (action.startsWith("lateral")) return movesSideways.value;
    if (action === "talk") return hello.value?.voice != null;
    if (action === "cameras") return (hello.value?.cameras.length ?? 0) > 0;
    return true;
  });
}
