import { useActions, useState } from "./context";
import { DriveButton } from "./DriveButton";
import { ArrowIcon } from "./icons";
import { joinWords } from "./words";

const AXIS_STEP = 0.05;

/** The controls; only whoever drives can press them. */
export function DrivePanel() {
  const { drivingTurn, hello } = useState();
  const { stop } = useActions();
  const isDriving = drivingTurn.value !== null;
  const axes = hello.value?.robot.axes ?? [];
  return (
    <section class="drive" aria-label="Drive">
      <div class="pad">
        <DriveButton direction="forward" name="Forward">
          <ArrowIcon />
        </DriveButton>
        <DriveButton direction="left" name="Left">
          <ArrowIcon />
        </DriveButton>
        <button type="button" class="stop-button" disabled={!isDriving} onClick={stop}>
          Stop
        </button>
        <DriveButton direction="right" name="Right">
          <ArrowIcon />
        </DriveButton>
        <DriveButton direction="back" name="Back">
          <ArrowIcon />
        </DriveButton>
      </div>
      <div class="trim">
        <Speed />
        {axes.length > 0 && (
          <div class="axes">
            {axes.map((axis) => (
              <Axis key={axis} axis={axis} />
            ))}
          </div>
        )}
      </div>
      <Hint />
    </section>
  );
}

function Speed() {
  const { preferences } = useState();
  const { setSpeed } = useActions();
  return (
    <div class="speed" role="radiogroup" aria-label="Speed">
      {(["fine", "gross"] as const).map((speed) => (
        <label key={speed} class="segment">
          <input
            type="radio"
            name="speed"
            value={speed}
            checked={preferences.value.speed === speed}
            onChange={() => setSpeed(speed)}
          />
          <span>{speed === "fine" ? "Fine" : "Gross"}</span>
        </label>
      ))}
    </div>
  );
}

function Axis({ axis }: { axis: string }) {
  const { axes, drivingTurn } = useState();
  const { setAxis } = useActions();
  return (
    <label class="axis">
      <span>{axis}</span>
      <input
        type="range"
        min={-1}
        max={1}
        step={AXIS_STEP}
        value={axes.value[axis] ?? 0}
        disabled={drivingTurn.value === null}
        onInput={(event) => setAxis(axis, event.currentTarget.valueAsNumber)}
      />
    </label>
  );
}

/** One line below the controls: why the robot stands, or how to drive it. */
function Hint() {
  const { drivingTurn, driveReason, isConnected, me } = useState();
  if (drivingTurn.value === null) {
    return (
      <p class="hint" id="drive-hint">
        {isConnected.value && joinWords(me.value)}
      </p>
    );
  }
  return (
    <p
      class={driveReason.value ? "hint is-reason" : "hint is-keys"}
      id="drive-hint"
      aria-live="polite"
    >
      {driveReason.value ?? "Arrow keys or W A S D drive, Space stops."}
    </p>
  );
}
