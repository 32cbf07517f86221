import type { TargetedKeyboardEvent, TargetedMouseEvent, TargetedPointerEvent } from "preact";
import { useCallback, useEffect, useMemo } from "preact/hooks";
import { codeOf } from "../drive/codeOf";
import { fingerHolder } from "../drive/inputState";
import { KeysDown } from "../drive/keysDown";
import { useActions } from "./context";
import { PRESSING } from "./keys";

type Pointer = TargetedPointerEvent<HTMLButtonElement>;
type Key = TargetedKeyboardEvent<HTMLButtonElement>;

/**
 * The keys that hold the focused element. `release` is called where a key's release never comes,
 * when the focus is lost, and when the element is removed; it must stay the same function.
 */
export function useKeysDown(release: () => void) {
  const keys = useMemo(() => new KeysDown(release), [release]);
  const clear = () => {
    keys.clear();
    release();
  };
  useEffect(() => clear, [keys]);
  return { keys, clear };
}

/**
 * The handlers of a button that works while it is pressed: by one or more fingers, the mouse, or
 * Space and Enter with the focus, as `focusHolder`. `release` returns whether anything was held,
 * and must stay the same function: it is also called when the button is removed.
 */
export function useHeld(
  focusHolder: string,
  hold: (holder: string) => void,
  release: (holder: string) => boolean,
) {
  const { letGo } = useActions();
  const letFocusGo = useCallback(() => void release(focusHolder), [release, focusHolder]);
  const { keys, clear } = useKeysDown(letFocusGo);
  const finger = (event: Pointer) => fingerHolder(event.pointerId);
  // After an ordinary release nothing is held: anything still held was cancelled by the system.
  const onLost = (event: Pointer) => {
    if (release(finger(event))) letGo();
  };
  return {
    onPointerDown(event: Pointer) {
      if (event.button !== 0) return;
      // Prevent the focus, which would give Space to this button, and a text selection.
      event.preventDefault();
      event.currentTarget.setPointerCapture(event.pointerId);
      hold(finger(event));
    },
    onPointerUp(event: Pointer) {
      release(finger(event));
    },
    onPointerCancel: onLost,
    onLostPointerCapture: onLost,
    onMouseDown(event: TargetedMouseEvent<HTMLButtonElement>) {
      event.preventDefault();
    },
    // A long touch opens a menu on some phones.
    onContextMenu(event: TargetedMouseEvent<HTMLButtonElement>) {
      event.preventDefault();
      event.stopPropagation();
    },
    onKeyDown(event: Key) {
      if (!PRESSING.has(codeOf(event))) return;
      event.preventDefault();
      const isNew = keys.press(event);
      // A press with Meta may get no release.
      if (isNew && keys.has(event)) hold(focusHolder);
    },
    onKeyUp(event: Key) {
      if (PRESSING.has(codeOf(event))) event.preventDefault();
      keys.lift(event);
    },
    onBlur: clear,
  };
}
