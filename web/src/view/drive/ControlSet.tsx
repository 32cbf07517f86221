import "../../style/controls.css";
import { useCallback } from "preact/hooks";
import { codeOf } from "../../drive/codeOf";
import { controlOf } from "../../drive/controlKeys";
import { fingerHolder } from "../../drive/inputState";
import type { ControlInfo } from "../../messages";
import { figure, t } from "../../words/words";
import { useActions, useState } from "../context";
import { Segment } from "../Segment";
import { useHeld, useKeysDown } from "../useHeld";
import { keyName } from "./keyHint";

/** Keys that move a focused slider. */
const SLIDING = /^(Arrow.*|Home|End|PageUp|PageDown)$/;

/** The shown controls, each by its kind. */
export function ControlSet({ shown }: { shown: readonly ControlInfo[] }) {
  return (
    <fieldset class="controls" aria-label={t("controls.name")}>
      {shown.map((control) => (
        <Control key={control.name} control={control} />
      ))}
    </fieldset>
  );
}

function Control({ control }: { control: ControlInfo }) {
  switch (control.kind) {
    case "button":
      return <Hold control={control} />;
    case "toggle":
      return <Toggle control={control} />;
    case "slider":
      return <Slide control={control} />;
    case "choice":
      return <Choose control={control} />;
  }
}

/** A control's value, and whether it can be used now. */
function useControl(control: ControlInfo) {
  const { mayMove, room, usableControls, wantedControls, heldControls } = useState();
  const { name } = control;
  const isUsable = usableControls.value.includes(control) && (!control.moves || mayMove.value);
  const value = wantedControls.value[name] ?? room.value?.controls[name];
  return { isDisabled: !isUsable, isHeld: heldControls.value.has(name), value };
}

/** A button that works while it is pressed, like one that drives. */
function Hold({ control }: { control: ControlInfo }) {
  const { isDisabled, isHeld } = useControl(control);
  const { holdControl, releaseControl } = useActions();
  const { name } = control;
  const holding = useHeld(`control ${name}`, (by) => holdControl(by, name), releaseControl);
  return (
    <button
      type="button"
      class={isHeld ? "control is-held" : "control"}
      disabled={isDisabled}
      aria-keyshortcuts={useKey(control)}
      {...holding}
    >
      <Name control={control} />
    </button>
  );
}

function Toggle({ control }: { control: ControlInfo }) {
  const { isDisabled, value } = useControl(control);
  const { toggleControl } = useActions();
  return (
    <button
      type="button"
      class="control"
      disabled={isDisabled}
      aria-pressed={value === 1}
      aria-keyshortcuts={useKey(control)}
      onClick={() => toggleControl(control.name)}
    >
      <Name control={control} />
    </button>
  );
}

/** A slider; one that moves something is held while it is slid, by any means. */
function Slide({ control }: { control: ControlInfo }) {
  const { name, min, max, step, moves } = control;
  const { isDisabled, isHeld, value } = useControl(control);
  const { holdControl, releaseControl, slideControl } = useActions();
  const holder = `control ${name}`;
  const hold = (by: string) => {
    if (moves) holdControl(by, name);
  };
  const letGo = useCallback(() => void releaseControl(holder), [releaseControl, holder]);
  const { keys, clear } = useKeysDown(letGo);
  return (
    <label class={isHeld ? "control is-slider is-held" : "control is-slider"}>
      <bdi class="control-name">{control.label}</bdi>
      <input
        type="range"
        min={min}
        max={max}
        step={step}
        aria-label={control.label}
        value={value ?? (moves ? (min + max) / 2 : min)}
        disabled={isDisabled}
        // The window receives the pointerup wherever it happens.
        onPointerDown={(event) => hold(fingerHolder(event.pointerId))}
        onKeyDown={(event) => {
          if (!SLIDING.test(codeOf(event))) return;
          keys.press(event);
          if (keys.has(event)) hold(holder);
        }}
        onKeyUp={(event) => keys.lift(event)}
        onBlur={clear}
        onInput={(event) => slideControl(name, event.currentTarget.valueAsNumber)}
      />
      <output>{value === undefined ? "" : figure(value)}</output>
    </label>
  );
}

function Choose({ control }: { control: ControlInfo }) {
  const { isDisabled, value } = useControl(control);
  const { setControl } = useActions();
  return (
    <fieldset class="control is-choice" aria-label={control.label}>
      <bdi class="control-name" aria-hidden="true">
        {control.label}
      </bdi>
      <div class="choices">
        {control.choices.map((choice, at) => (
          <Segment
            key={choice}
            isChosen={value === at}
            isDisabled={isDisabled}
            onChoose={() => setControl(control.name, at)}
          >
            <bdi>{choice}</bdi>
          </Segment>
        ))}
      </div>
    </fieldset>
  );
}

/** The control's name and key. */
function Name({ control }: { control: ControlInfo }) {
  const key = useKey(control);
  return (
    <>
      <bdi class="control-name">{control.label}</bdi>
      {key && (
        <span class="control-key" aria-hidden="true">
          {key}
        </span>
      )}
    </>
  );
}

/** The label of the key that presses the control, unless the user has assigned that key. */
function useKey(control: ControlInfo): string | undefined {
  const { hello, keys } = useState();
  const { key } = control;
  const is = controlOf(hello.value?.controls ?? [], keys.value, key) === control;
  return key !== "" && is ? keyName(key) : undefined;
}
