import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useCallback, useEffect } from "preact/hooks";
import { codeOf } from "../drive/codeOf";
import { useKeysDown } from "./useHeld";

/** Longer than an accidental press; the style sheet fills the button in this time. */
export const HOLD_MS = 800;
const HOLDING = new Set(["Enter", "NumpadEnter"]);

interface Props {
  /** Called once the button has been held long enough. */
  onHeld: () => void;
  children: ComponentChildren;
}

/**
 * A button that acts after being held with the mouse, a finger or Enter; never with Space, which
 * stops the robot and may still be repeating.
 */
export function HoldButton({ onHeld, children }: Props) {
  const isHeld = useSignal(false);
  const held = isHeld.value;
  const begin = () => {
    isHeld.value = true;
  };
  const end = useCallback(() => {
    isHeld.value = false;
  }, [isHeld]);
  const { keys, clear } = useKeysDown(end);
  useEffect(() => {
    if (!held) return;
    const ending = new AbortController();
    const timer = setTimeout(() => {
      isHeld.value = false;
      onHeld();
    }, HOLD_MS);
    window.addEventListener("blur", end, ending);
    document.addEventListener("visibilitychange", end, ending);
    return () => {
      clearTimeout(timer);
      ending.abort();
    };
  }, [held, isHeld, end, onHeld]);
  return (
    <button
      type="button"
      class={held ? "hold-button is-held" : "hold-button"}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        // Keep the hold even if the page moves under the pointer, as when a banner disappears.
        event.currentTarget.setPointerCapture(event.pointerId);
        begin();
      }}
      onPointerUp={end}
      onPointerCancel={end}
      onLostPointerCapture={end}
      onBlur={clear}
      onKeyDown={(event) => {
        if (codeOf(event) === "Space" || HOLDING.has(codeOf(event))) event.preventDefault();
        if (HOLDING.has(codeOf(event)) && keys.press(event) && keys.has(event)) begin();
      }}
      onKeyUp={(event) => {
        event.preventDefault();
        keys.lift(event);
      }}
      onContextMenu={(event) => {
        // A long touch opens a menu on some phones.
        event.preventDefault();
        event.stopPropagation();
      }}
    >
      <span>{children}</span>
    </button>
  );
}
