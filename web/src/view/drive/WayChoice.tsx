import { CONTROLS, type Control, RANGES, wayInForce } from "../../drive/drivePreferences";
import { WAYS } from "../../drive/ways";
import { t } from "../../words/words";
import { useActions, useState } from "../context";
import { seconds, WAY_NAMES } from "./names";
import { Slider } from "./Slider";

/** How a direction drives: held, in steps, by clicks, or offered to a switch. */
export function WayChoice() {
  const { preferences, hello } = useState();
  const { setDriving } = useActions();
  const mayClick = hello.value?.click_to_move === true;
  const { stepMs } = preferences.value;
  const way = wayInForce(preferences.value, mayClick);
  return (
    <fieldset class="ways-group">
      <legend>{t("ways.way")}</legend>
      <div class="ways-choice">
        {WAYS.map((one) => (
          <label key={one} class="segment">
            <input
              type="radio"
              name="way"
              value={one}
              checked={way === one}
              disabled={one === "click" && !mayClick}
              onChange={() => setDriving({ way: one })}
            />
            <span>{t(WAY_NAMES[one][0])}</span>
          </label>
        ))}
      </div>
      <p class="quiet">
        {t(WAY_NAMES[way][1])} {!mayClick && t("ways.way_click_forbidden")}
      </p>
      {way === "hold" && <ScreenControl />}
      {(way === "step" || way === "scan") && (
        <Slider
          name={t("ways.step_length")}
          value={stepMs}
          range={RANGES.stepMs}
          said={seconds(stepMs)}
          onSlide={(ms) => setDriving({ stepMs: ms })}
        />
      )}
      {way === "scan" && <Switches />}
    </fieldset>
  );
}

/** The choice of a stick or buttons on the screen. */
function ScreenControl() {
  const { preferences } = useState();
  const { setDriving } = useActions();
  return (
    <label class="field">
      <span>{t("ways.control")}</span>
      <select
        value={preferences.value.control ?? ""}
        onChange={(event) =>
          setDriving({ control: (event.currentTarget.value || null) as Control | null })
        }
      >
        {CONTROLS.map((one) => (
          <option key={one} value={one ?? ""}>
            {t(CONTROL_NAMES[one ?? "auto"])}
          </option>
        ))}
      </select>
    </label>
  );
}

const CONTROL_NAMES = {
  auto: "ways.control_auto",
  stick: "ways.joystick",
  buttons: "ways.control_buttons",
} as const;

function Switches() {
  const { preferences } = useState();
  const { setDriving } = useActions();
  const { switches, dwellMs } = preferences.value;
  return (
    <>
      <label class="field">
        <span>{t("ways.switches")}</span>
        <select
          value={switches}
          onChange={(event) => setDriving({ switches: event.currentTarget.value === "2" ? 2 : 1 })}
        >
          <option value={1}>{t("ways.switches_one")}</option>
          <option value={2}>{t("ways.switches_two")}</option>
        </select>
      </label>
      {switches === 1 && (
        <Slider
          name={t("ways.dwell")}
          value={dwellMs}
          range={RANGES.dwellMs}
          said={seconds(dwellMs)}
          onSlide={(ms) => setDriving({ dwellMs: ms })}
        />
      )}
    </>
  );
}
