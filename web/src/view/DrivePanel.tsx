import { controlInForce, wayInForce } from "../drive/drivePreferences";
import type { Direction } from "../drive/inputState";
import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { DriveButton } from "./DriveButton";
import { directionNames } from "./directionNames";
import { Axes } from "./drive/Axes";
import { keyHint } from "./drive/keyHint";
import { RobotControls } from "./drive/RobotControls";
import { ScanPad } from "./drive/ScanPad";
import { ArrowIcon, TurnIcon } from "./icons";
import { Joystick } from "./Joystick";
import { joinWords, released } from "./pageWords";
import { Segment } from "./Segment";
import { StopButton } from "./StopButton";
import { VoicePanel } from "./VoicePanel";

/** The controls: Stop for every viewer, the rest for the operator. */
export function DrivePanel() {
  const { me, preferences, hello, movesSideways } = useState();
  if (me.value === null || me.value.role === "observer") {
    return (
      <section class="drive is-watching" aria-label={t("drive.name")}>
        <StopButton />
        <RobotControls />
        <VoicePanel />
      </section>
    );
  }
  const way = wayInForce(preferences.value, hello.value?.click_to_move);
  const isCoarse = window.matchMedia("(pointer: coarse)").matches;
  const isStick = controlInForce(preferences.value, way, isCoarse) === "stick";
  return (
    <section class="drive" aria-label={t("drive.name")}>
      <div class={`pad${isStick ? " is-stick" : ""}${movesSideways.value ? " is-planar" : ""}`}>
        {isStick ? <Sticks /> : <Buttons />}
        <StopButton />
      </div>
      <ScanPad />
      <div class="trim">
        <Speed />
        <Axes />
      </div>
      <RobotControls />
      <VoicePanel />
      <Hint />
    </section>
  );
}

/** A stick for one thumb; for a robot that moves sideways, one for each. */
function Sticks() {
  const { movesSideways } = useState();
  if (!movesSideways.value) return <Joystick use="drive" />;
  return (
    <>
      <Joystick use="move" />
      <Joystick use="turn" />
    </>
  );
}

/** As they are on the screen, row by row. */
const IN_ROWS: readonly Direction[] = [
  "lateral_left",
  "forward",
  "lateral_right",
  "left",
  "back",
  "right",
];

function Buttons() {
  const { movesSideways } = useState();
  const isPlanar = movesSideways.value;
  const names = directionNames(isPlanar);
  return IN_ROWS.filter((one) => isPlanar || !one.startsWith("lateral")).map((direction) => (
    <DriveButton key={direction} direction={direction} name={t(names[direction])}>
      {isPlanar && (direction === "left" || direction === "right") ? <TurnIcon /> : <ArrowIcon />}
    </DriveButton>
  ));
}

function Speed() {
  const { preferences } = useState();
  const { setSpeed } = useActions();
  return (
    <fieldset class="speed" aria-label={t("drive.speed")}>
      {(["slow", "fast"] as const).map((speed) => (
        <Segment
          key={speed}
          isChosen={preferences.value.speed === speed}
          onChoose={() => setSpeed(speed)}
        >
          <span>{speed === "slow" ? t("drive.slow") : t("drive.fast")}</span>
        </Segment>
      ))}
    </fieldset>
  );
}

/** Beside the controls: why the robot does not move or is slow, or how to drive. */
function Hint() {
  const state = useState();
  const { drivingTurn, driveReason, hello, isConnected } = state;
  const { isFreshlyReleased, keys, me, preferences, stopNumber } = state;
  if (drivingTurn.value === null) {
    return (
      <p class="hint" id="drive-hint">
        {isConnected.value && joinWords(me.value, hello.value?.may_queue)}
      </p>
    );
  }
  // The turn card already says who stopped the robot and what to do.
  if (stopNumber.value !== null) return <p class="hint" id="drive-hint" />;
  const reason = said(driveReason.value) ?? (isFreshlyReleased.value ? released() : null);
  return (
    <p class={reason ? "hint is-reason" : "hint is-keys"} id="drive-hint" aria-live="polite">
      {reason ?? keyHint(preferences.value, keys.value, hello.value)}
    </p>
  );
}
