/** When a user is new here: until they have driven, or have read how to. */

import { effect } from "@preact/signals";
import type { Preferences } from "../preferences";
import type { State } from "../state";

/** Ends the welcome once the user has driven; `keep` stores that on this device. */
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
