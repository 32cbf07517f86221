import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../words/words";
import { useSession, useState } from "./context";

const LOOK_EVERY_MS = 100;
const NAMES = { 1: ["sound.level"], 2: ["sound.level_left", "sound.level_right"] } as const;

/** The level of the robot's sound; per ear if it is stereo and the built-in player plays it. */
export function SoundMeter() {
  const { isSoundOn, served } = useState();
  const { soundLevels } = useSession();
  const levels = useSignal<readonly number[]>([]);
  const isOn = isSoundOn.value;
  useEffect(() => {
    if (!isOn) return;
    const looking = setInterval(() => {
      void soundLevels().then((found) => {
        levels.value = found;
      });
    }, LOOK_EVERY_MS);
    return () => {
      clearInterval(looking);
      levels.value = [];
    };
  }, [isOn, soundLevels, levels]);
  const found = levels.value;
  const isStereo = found.length === 2 && (served.value?.sound_channels ?? 0) > 1;
  const shown = isStereo ? found : [Math.max(0, ...found)];
  return (
    <div class={found.length > 0 ? "sound-meter" : "sound-meter is-off"}>
      {NAMES[isStereo ? 2 : 1].map((name, side) => (
        <meter key={name} class="level" aria-label={t(name)} min={0} max={1} value={shown[side]} />
      ))}
    </div>
  );
}
