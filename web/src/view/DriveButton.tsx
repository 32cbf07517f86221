import type { ComponentChildren } from "preact";
import type { Direction } from "../drive/inputState";
import { useActions, useState } from "./context";
import { useHeld } from "./useHeld";

interface Props {
  direction: Direction;
  name: string;
  children: ComponentChildren;
}

/** A button that drives while it is pressed. */
export function DriveButton({ direction, name, children }: Props) {
  const { held, mayMove } = useState();
  const { press, release } = useActions();
  const holding = useHeld(`button ${direction}`, (by) => press(by, direction), release);
  return (
    <button
      type="button"
      class={`drive-button is-${direction}${held.value.has(direction) ? " is-held" : ""}`}
      disabled={!mayMove.value}
      aria-describedby="drive-hint"
      {...holding}
    >
      {children}
      <span class="drive-name">{name}</span>
    </button>
  );
}
