/** How loud the sound plays here, and on which device. */

import type { Preferences } from "../preferences";
import type { State } from "../state";
import { t } from "../words/words";
import { devicesOf, type Output, watchOutput } from "./outputs";
import type { SoundPlayback } from "./soundPlayback";

export interface HearingActions {
  /** From 0 to 1; a change also unmutes. */
  setVolume(volume: number): void;
  setMuted(muted: boolean): void;
  /** Mutes or unmutes; unmuting also starts the sound if Start was never pressed. */
  toggleMute(): void;
  /** Plays on another device; null for the browser's default. */
  setOutput(output: Output | null): void;
}

interface Options {
  state: State;
  sound: Pick<SoundPlayback, "volume" | "isMuted" | "setOutput">;
  prefer(change: Partial<Preferences>): void;
  /** Switches the sound on. */
  start(): void;
  say(text: string): void;
}

export function createHearing({ state, sound, prefer, start, say }: Options): HearingActions {
  const { volume, muted } = state.preferences.peek();
  sound.volume = volume;
  sound.isMuted = muted;
  let unwatch = () => {};

  const setMuted = (isMuted: boolean) => {
    sound.isMuted = isMuted;
    prefer({ muted: isMuted });
  };

  async function setOutput(output: Output | null): Promise<void> {
    unwatch();
    state.output.value = output;
    const isThere = await sound.setOutput(output?.id ?? "");
    if (!output || state.output.peek() !== output) return;
    if (isThere) watch(output);
    else lost(output);
  }

  function watch(output: Output): void {
    const devices = devicesOf();
    if (devices) unwatch = watchOutput(devices, output.id, () => lost(output));
  }

  function lost(output: Output): void {
    void setOutput(null);
    say(t("watch.output.gone", { name: output.name }));
  }

  return {
    setVolume(wanted) {
      const kept = Math.min(1, Math.max(0, wanted));
      sound.volume = kept;
      prefer({ volume: kept });
      if (state.preferences.peek().muted) setMuted(false);
    },
    setMuted,
    toggleMute() {
      const isHeard = state.isSoundOn.peek() && !state.preferences.peek().muted;
      if (!state.isSoundOn.peek()) start();
      setMuted(isHeard);
    },
    setOutput: (output) => void setOutput(output),
  };
}
