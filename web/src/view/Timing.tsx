import { useId } from "preact/hooks";
import { POLICIES, type Preferences } from "../preferences";
import { t } from "../words/words";
import { useActions, useState } from "./context";

const NAMES = { "audio-master": "smooth", "video-first": "immediate" } as const;

const nameOf = (policy: Preferences["policy"]) => (policy ? NAMES[policy] : "automatic");

/** Smooth or immediate; no choice if the server has one for everybody. */
export function Timing() {
  const { preferences, playout } = useState();
  const { setPolicy } = useActions();
  const id = useId();
  if (playout.value && !(playout.value.policy in NAMES)) return null;
  const chosen = preferences.value.policy;
  return (
    <fieldset class="timing">
      <legend>{t("watch.timing")}</legend>
      {POLICIES.map((one) => (
        <label key={one} class="check">
          <input
            type="radio"
            name={id}
            checked={one === chosen}
            aria-describedby={`${id}-what`}
            onChange={() => setPolicy(one)}
          />
          <span>{t(`watch.timing.${nameOf(one)}`)}</span>
        </label>
      ))}
      <p id={`${id}-what`} class="quiet">
        {t(`watch.timing.${nameOf(chosen)}.what`)}
      </p>
    </fieldset>
  );
}
