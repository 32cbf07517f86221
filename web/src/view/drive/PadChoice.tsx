import { useSignal } from "@preact/signals";
import { RANGES } from "../../drive/drivePreferences";
import type { PadState } from "../../drive/gamepads";
import type { Learnt } from "../../drive/learntParts";
import type { PadLayout, PadPart, PadSettings } from "../../drive/padReading";
import { t } from "../../words/words";
import { useActions, useState } from "../context";
import { Switch } from "../Switch";
import { percent, written } from "./names";
import { PadParts } from "./PadParts";
import { partName } from "./padNames";
import { Slider } from "./Slider";

/** Which gamepad drives, if any, and how it answers. */
export function PadChoice() {
  const { pads } = useState();
  const { useGamepad: choose } = useActions();
  const { found, chosen } = pads.value;
  return (
    <fieldset class="ways-group">
      <legend>{t("ways.pad")}</legend>
      {found.length > 0 && (
        <label class="field">
          <span>{t("ways.pad")}</span>
          <select
            value={chosen ?? ""}
            onChange={({ currentTarget: { value } }) => choose(value === "" ? null : Number(value))}
          >
            <option value="">{t("ways.pad_none")}</option>
            {found.map(({ index, id }) => (
              <option key={index} value={index}>
                {id}
              </option>
            ))}
          </select>
        </label>
      )}
      <p class="quiet" aria-live="polite">
        <PadWords />
      </p>
      <PadRestButton />
      {chosen !== null && <PadFields />}
    </fieldset>
  );
}

function PadWords() {
  const { pads, mayMove, movesSideways, preferences } = useState();
  const { found, chosen, isReady, held, unmoved } = pads.value;
  if (!("getGamepads" in navigator)) return <>{t("ways.pad_missing")}</>;
  if (found.length === 0) return <>{t("ways.pad_search")}</>;
  if (chosen === null) return null;
  const layout = chosenLayout(pads.value);
  const id = found.find(({ index }) => index === chosen)?.id ?? "";
  const learnt = preferences.value.gamepad.learnt[id] ?? {};
  const actions = actionsOf(layout, learnt, movesSideways.value);
  if (!mayMove.value) return <>{t("ways.pad_idle", { actions })}</>;
  if (isReady) return <>{t("ways.pad_ready", { actions })}</>;
  const names = (parts: readonly PadPart[]) =>
    [...new Set(parts.map((part) => partName(part, layout)))].join(", ");
  const [what, axes] = [names(held), names(unmoved)];
  if (what === "" && axes !== "") return <>{t("ways.pad_unmoved", { what: axes })}</>;
  return (
    <>
      {what === "" ? t("ways.pad_arming") : t("ways.pad_holds", { what })}{" "}
      {held.some(isAxis) && t("ways.pad_aside")}
    </>
  );
}

function chosenLayout({ found, chosen }: PadState): PadLayout {
  return found.find(({ index }) => index === chosen)?.layout ?? "bare";
}

const isAxis = ({ kind }: PadPart) => kind === "axis";

/** If an axis seems held: a button to say that nobody touches it, and that it rests there. */
function PadRestButton() {
  const { pads, mayMove, preferences } = useState();
  const { padRestNow, setDriving } = useActions();
  const isRestless = useSignal(false);
  const { found, chosen, isReady, held } = pads.value;
  const id = found.find(({ index }) => index === chosen)?.id;
  if (id === undefined || !mayMove.value || isReady || !held.some(isAxis)) return null;
  const take = () => {
    const rest = padRestNow();
    isRestless.value = rest === null;
    const { gamepad } = preferences.peek();
    if (rest) setDriving({ gamepad: { ...gamepad, rests: { ...gamepad.rests, [id]: rest } } });
  };
  return (
    <>
      <button type="button" onClick={take}>
        {t("ways.pad_rest")}
      </button>
      <p class="ways-told" role="status">
        {isRestless.value && t("ways.pad_restless")}
      </p>
    </>
  );
}

/** What the gamepad's buttons do. */
function actionsOf(layout: PadLayout, learnt: Learnt, movesSideways: boolean): string {
  if (layout === "bare" && !learnt.stop) return t("ways.pad_no_stop");
  const name = (at: number, use = "") => partName(learnt[use] ?? { kind: "button", at }, layout);
  const actions = t("ways.pad_actions", { stop: name(1, "stop"), speed: name(0, "speed") });
  if (!movesSideways || layout !== "standard") return actions;
  return t("ways.pad_sideways", { actions, left: name(4), right: name(5) });
}

function PadFields() {
  const { pads, preferences, movesSideways } = useState();
  const { setDriving } = useActions();
  const { gamepad } = preferences.value;
  const { found, chosen } = pads.value;
  const pad = found.find(({ index }) => index === chosen);
  const { triggers, deadZone, curve } = gamepad;
  const isPlanar = movesSideways.value && chosenLayout(pads.value) === "standard";
  const which = isPlanar ? "planarTurn" : "turn";
  const set = (change: Partial<PadSettings>) => setDriving({ gamepad: { ...gamepad, ...change } });
  return (
    <>
      <label class="field">
        <span>{t("ways.pad_turn")}</span>
        <select
          value={gamepad[which]}
          onChange={(event) =>
            set({ [which]: event.currentTarget.value === "right" ? "right" : "left" })
          }
        >
          <option value="left">
            {t(isPlanar ? "ways.pad_planar_left" : "ways.pad_turn_left")}
          </option>
          <option value="right">
            {t(isPlanar ? "ways.pad_planar_right" : "ways.pad_turn_right")}
          </option>
        </select>
      </label>
      <Switch
        name={t("ways.pad_triggers")}
        isOn={triggers}
        onSwitch={(on) => set({ triggers: on })}
      />
      <Slider
        name={t("ways.pad_dead_zone")}
        value={deadZone}
        range={RANGES.deadZone}
        said={percent(deadZone)}
        onSlide={(value) => set({ deadZone: value })}
      />
      <Slider
        name={t("ways.pad_curve")}
        value={curve}
        range={RANGES.curve}
        said={written(curve)}
        onSlide={(value) => set({ curve: value })}
      />
      {pad && <PadParts key={pad.id} id={pad.id} layout={pad.layout} />}
    </>
  );
}
