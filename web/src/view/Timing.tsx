import { useId } from "preact/hooks";
import { POLICIES, type Preferences } from "../preferences";
import { type Code, t } from "../words/words";
import { useActions, useState } from "./context";

/** Its name, and what it does. */
type Words = readonly [name: Code, what: Code];

const AUTOMATIC: Words = ["watch.timing.automatic", "watch.timing.automatic.what"];
const NAMES: Record<NonNullable<Preferences["policy"]>, Words> = {
  "audio-master": ["watch.timing.smooth", "watch.timing.smooth.what"],
  "video-first": ["watch.timing.immediate", "watch.timing.immediate.what"],
};

const wordsOf = (policy: Preferences["policy"]) => (policy ? NAMES[policy] : AUTOMATIC);

/** Automatic, smooth or immediate; no choice if the server sets one for everybody. */
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
          <span>{t(wordsOf(one)[0])}</span>
        </label>
      ))}
      <p id={`${id}-what`} class="quiet">
        {t(wordsOf(chosen)[1])}
      </p>
    </fieldset>
  );
}
