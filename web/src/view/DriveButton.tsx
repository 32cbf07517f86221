import type { ComponentChildren, TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useEffect } from "preact/hooks";
import { type Direction, fingerHolder } from "../drive/inputState";
import { useActions, useState } from "./context";
import { PRESSING } from "./keys";

type Pointer = TargetedPointerEvent<HTMLButtonElement>;
type Key = TargetedKeyboardEvent<HTMLButtonElement>;

interface Props {
  direction: Direction;
  name: string;
  children: ComponentChildren;
}

/**
 * A button that drives while it is pressed: by one or more fingers, the mouse, or Space and Enter
 * while it has the focus.
 */
export function DriveButton({ direction, name, children }: Props) {
  const { held, mayMove } = useState();
  const { press, release, letGo } = useActions();
  const focusHolder = `button ${direction}`;
  const finger = (event: Pointer) => fingerHolder(event.pointerId);

  useEffect(() => () => void release(focusHolder), [release, focusHolder]);

  const onPointerDown = (event: Pointer) => {
    if (event.button !== 0) return;
    // Prevent the focus, which would give Space to this button, and a text selection.
    event.preventDefault();
    event.currentTarget.setPointerCapture(event.pointerId);
    press(finger(event), direction);
  };
  // After an ordinary release nothing is held; anything still held was cancelled by the system.
  const onLost = (event: Pointer) => {
    if (release(finger(event))) letGo();
  };
  const onKeyDown = (event: Key) => {
    if (!PRESSING.has(event.code)) return;
    event.preventDefault();
    if (!event.repeat) press(focusHolder, direction);
  };
  const onKeyUp = (event: Key) => {
    if (!PRESSING.has(event.code)) return;
    event.preventDefault();
    release(focusHolder);
  };

  return (
    <button
      type="button"
      class={`drive-button is-${direction}${held.value.has(direction) ? " is-held" : ""}`}
      disabled={!mayMove.value}
      aria-describedby="drive-hint"
      onPointerDown={onPointerDown}
      onPointerUp={(event) => release(finger(event))}
      onPointerCancel={onLost}
      onLostPointerCapture={onLost}
      // A long touch would open a menu on some phones.
      onContextMenu={(event) => {
        event.preventDefault();
        event.stopPropagation();
      }}
      onMouseDown={(event) => event.preventDefault()}
      onKeyDown={onKeyDown}
      onKeyUp={onKeyUp}
      onBlur={() => release(focusHolder)}
    >
      {children}
      <span class="drive-name">{name}</span>
    </button>
  );
}
