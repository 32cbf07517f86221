import type { TargetedKeyboardEvent } from "preact";
import { useCallback } from "preact/hooks";
import { keyedAxes } from "../../drive/axisKeys";
import { codeOf } from "../../drive/codeOf";
import { fingerHolder } from "../../drive/inputState";
import { keyWords } from "../../drive/keyCaps";
import { t } from "../../words/words";
import { useActions, useState } from "../context";
import { axisWords } from "../pageWords";
import { useKeysDown } from "../useHeld";

const AXIS_STEP = 0.05;
/** Keys that move a focused slider. */
const SLIDING = /^(Arrow.*|Home|End|PageUp|PageDown)$/;

/** The robot's axes besides its wheels: a slider each, and a button to centre them all. */
export function Axes() {
  const { hello, mayMove } = useState();
  const { recentre } = useActions();
  const axes = hello.value?.robot.axes ?? [];
  if (axes.length === 0) return null;
  return (
    <fieldset class="axes" aria-label={t("ways.axes")}>
      {axes.map((axis) => (
        <Axis key={axis} axis={axis} />
      ))}
      <button type="button" disabled={!mayMove.value} onClick={recentre}>
        {t("ways.recentre")}
      </button>
    </fieldset>
  );
}

/**
 * Holding a slider counts as holding a control. Its axis follows every change, however it is made.
 * Left is the positive end of a pan, as of turning.
 */
function Axis({ axis }: { axis: string }) {
  const { axes, cameras, mayMove } = useState();
  const { setAxis, press, release } = useActions();
  const focusHolder = `axis ${axis}`;
  const letGo = useCallback(() => void release(focusHolder), [release, focusHolder]);
  const { keys, clear } = useKeysDown(letGo);
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    if (!SLIDING.test(codeOf(event))) return;
    keys.press(event);
    if (keys.has(event)) press(focusHolder, null);
  };
  return (
    <label class="axis">
      <span>{axisWords(axis, cameras.value)}</span>
      <input
        type="range"
        dir={axis.startsWith("pan") ? "rtl" : "ltr"}
        min={-1}
        max={1}
        step={AXIS_STEP}
        value={axes.value[axis] ?? 0}
        disabled={!mayMove.value}
        aria-keyshortcuts={useShortcuts(axis)}
        // The window receives the pointerup wherever it happens.
        onPointerDown={(event) => press(fingerHolder(event.pointerId), null)}
        onKeyDown={onKeyDown}
        onKeyUp={(event) => keys.lift(event)}
        onBlur={clear}
        onInput={(event) => setAxis(axis, event.currentTarget.valueAsNumber)}
      />
    </label>
  );
}

/** The keys that move this axis, if it has any. */
function useShortcuts(axis: string): string | undefined {
  const { hello, keys: inForce } = useState();
  const keys = inForce.value;
  const at = keyedAxes(hello.value?.robot.axes ?? []).indexOf(axis);
  const all = [
    [...keys.axis1_plus, ...keys.axis1_minus],
    [...keys.axis2_plus, ...keys.axis2_minus],
  ][at];
  return all?.map(keyWords).join(" ");
}
