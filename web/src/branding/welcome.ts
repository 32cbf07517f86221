/** When somebody is new here: until they have driven, or have read how. */

import { effect } from "@preact/signals";
import type { Preferences } from "../preferences";
import type { State } from "../state";

/** Greets nobody again who has driven; `keep` remembers it on this device. */
export function listenFirstDrive(
  state: State,
  keep: (change: Partial<Preferences>) => void,
): () => void {
  return effect(() => {
    const { linear, angular } = state.motion.value;
    const drives = state.mayMove.value && (linear !== 0 || angular !== 0);
    if (drives && !state.preferences.peek().welcomed) keep({ welcomed: true });
  });
}
