import type { Panel } from "../state";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { msWords } from "./figures";
import { GaugeWarnings } from "./Gauges";
import { BatteryIcon, BumperIcon, EarIcon, MutedIcon } from "./icons";
import { LinkStatus } from "./LinkStatus";
import { isUndated, silenceWords } from "./pageWords";
import { robotName } from "./robotName";
import { numbersNamed } from "./robotNumbers";
import { SoundMeter } from "./SoundMeter";
import { TapeBadge } from "./TapeBadge";

/** Over the picture's upper edge: only what needs a glance while driving. */
export function Hud() {
  const { hello } = useState();
  return (
    <header class="hud">
      <h1 class="brand">
        <bdi>{robotName(hello.value)}</bdi>
      </h1>
      <LinkStatus />
      <TapeBadge />
      <div class="hud-figures">
        <Robot />
        <Speed />
        <Sound />
        <Delay />
      </div>
    </header>
  );
}

/** The robot's battery and bumper, if it reports them. */
function Robot() {
  const { room, isConnected } = useState();
  const robot = room.value?.robot;
  if (!robot || !isConnected.value) return null;
  const [battery] = numbersNamed("facts.battery", robot);
  const isLow = robot.battery_fraction !== null && robot.battery_fraction < LOW_BATTERY;
  return (
    <>
      {robot.bumpers > 0 && (
        <span class="chip is-poor">
          <BumperIcon />
          {t("hud.bumper")}
        </span>
      )}
      {battery && (
        <span class={isLow ? "chip is-poor" : "chip"} title={t("hud.battery")}>
          <BatteryIcon />
          <span class="figure">{battery}</span>
        </span>
      )}
      <GaugeWarnings />
    </>
  );
}

const LOW_BATTERY = 0.2;

/** The chosen speed, while driving. */
function Speed() {
  const { drivingTurn, preferences } = useState();
  if (drivingTurn.value === null) return null;
  const isFast = preferences.value.speed === "fast";
  return <span class="chip">{t(isFast ? "drive.fast" : "drive.slow")}</span>;
}

/** Whether the sound is on, with its level. */
function Sound() {
  const { isSoundOn, hello, preferences } = useState();
  const { setSound, toggleMute } = useActions();
  if (silenceWords(hello.value) !== null) return null;
  const isOn = isSoundOn.value;
  const isMuted = preferences.value.muted;
  return (
    <div class="hud-sound">
      <button
        type="button"
        class="chip chip-button"
        role="switch"
        aria-checked={isOn && !isMuted}
        aria-label={t("hud.sound")}
        onClick={() => (isOn && isMuted ? toggleMute() : setSound(!isOn))}
      >
        {isOn && !isMuted ? <EarIcon /> : <MutedIcon />}
      </button>
      <SoundMeter />
    </div>
  );
}

/** The picture's age as a colour and a number; opens the details. */
function Delay() {
  const { facts, room, isConnected, isSilent, hello, panel } = useState();
  const { open } = useActions();
  if (!isConnected.value) return null;
  const { pictureMs, soundMs } = facts.value;
  const isUnknown = isSilent.value || isUndated(room.value);
  const measuredMs = isUnknown ? null : (pictureMs ?? soundMs);
  // The clocks' error can make a fresh picture seem to come from the future.
  const ageMs = measuredMs === null ? null : Math.max(0, measuredMs);
  const limitMs = hello.value?.on_loss.slow_picture_age_ms;
  const isOpen = panel.value === DETAILS;
  return (
    <button
      type="button"
      class={`chip chip-button is-${delayLevel(ageMs, limitMs)}`}
      aria-expanded={isOpen}
      onClick={() => open(isOpen ? null : DETAILS)}
    >
      <span class="chip-name">{t("hud.delay")}</span>
      <span class="figure">{msWords(ageMs)}</span>
    </button>
  );
}

const DETAILS: Panel = "details";

/** Rates a delay: good where nobody notices it, poor where it slows the robot. */
export function delayLevel(ageMs: number | null, limitMs = 400): "good" | "fair" | "poor" {
  if (ageMs === null) return "fair";
  if (ageMs <= limitMs / 2) return "good";
  return ageMs <= limitMs ? "fair" : "poor";
}
