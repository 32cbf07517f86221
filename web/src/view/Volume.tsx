import { useId, useMemo } from "preact/hooks";
import { t } from "../words/words";
import { useActions, useState } from "./context";

/** Whether a page can change the volume here; on iOS only the device's buttons can. */
function canSetVolume(): boolean {
  const element = document.createElement("audio");
  element.volume = 0.5;
  return element.volume === 0.5;
}

/** The volume, and mute. */
export function Volume() {
  const { preferences, isSoundOn, player } = useState();
  const { setVolume, toggleMute } = useActions();
  const id = useId();
  const canSet = useMemo(canSetVolume, []);
  const { volume, muted } = preferences.value;
  const isHeard = isSoundOn.value && !muted;
  const percent = Math.round(volume * 100);
  return (
    <div class="volume">
      <button type="button" class="plain-button" aria-keyshortcuts="M" onClick={() => toggleMute()}>
        {t(isHeard ? "watch.mute" : "watch.unmute")}
      </button>
      {canSet || player.value.by === "built-in" ? (
        <label for={id} class="field">
          <span>{t("watch.volume")}</span>
          <input
            id={id}
            type="range"
            min={0}
            max={100}
            step={5}
            value={percent}
            aria-valuetext={t("watch.volume.value", { n: percent })}
            onInput={(event) => setVolume(event.currentTarget.valueAsNumber / 100)}
          />
        </label>
      ) : (
        <p class="quiet">{t("watch.volume.device")}</p>
      )}
    </div>
  );
}
