import type { TargetedKeyboardEvent, TargetedMouseEvent, TargetedPointerEvent } from "preact";
import { codeOf } from "../drive/codeOf";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { PRESSING } from "./keys";

/** Stop for everybody; it acts on touch, not on release. */
export function StopButton() {
  const { mayStop } = useState();
  const { stop } = useActions();
  const onPointerDown = (event: TargetedPointerEvent<HTMLButtonElement>) => {
    stop();
    // Prevent the focus, which would give Space to this button, and a text selection.
    event.preventDefault();
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLButtonElement>) => {
    if (!PRESSING.has(codeOf(event))) return;
    if (!event.repeat) stop();
    event.preventDefault();
  };
  // For presses without pointer or key, as by a screen reader.
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
      // Some browsers click on the keyup of Space.
      onKeyUp={(event) => event.preventDefault()}
      onClick={onClick}
      onContextMenu={(event) => event.preventDefault()}
    >
      {t("stop.stop")}
    </button>
  );
}
