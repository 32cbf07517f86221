import type { TargetedKeyboardEvent, TargetedMouseEvent, TargetedPointerEvent } from "preact";
import { useActions, useState } from "./context";
import { PRESSING } from "./keys";

/** Stop for everybody: it acts when it is touched, not when the touch ends. */
export function StopButton() {
  const { mayStop } = useState();
  const { stop } = useActions();
  const onPointerDown = (event: TargetedPointerEvent<HTMLButtonElement>) => {
    stop();
    // Neither the focus, which would give Space to this button, nor a text selection.
    event.preventDefault();
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLButtonElement>) => {
    if (!PRESSING.has(event.code)) return;
    if (!event.repeat) stop();
    event.preventDefault();
  };
  // Of a press that neither a pointer nor a key has made: that of a screen reader.
  const onClick = (event: TargetedMouseEvent<HTMLButtonElement>) => {
    if (event.detail === 0) stop();
  };
  return (
    <button
      type="button"
      class="stop-button"
      disabled={!mayStop.value}
      onPointerDown={onPointerDown}
      onMouseDown={(event) => event.preventDefault()}
      onKeyDown={onKeyDown}
      // Some browsers click when Space comes up.
      onKeyUp={(event) => event.preventDefault()}
      onClick={onClick}
      onContextMenu={(event) => event.preventDefault()}
    >
      Stop
    </button>
  );
}
