/** When a user is new here: until they have driven, or have read how to. */

import { effect } from "@preact/signals";
import { isMoving } from "../drive/inputState";
import type { Preferences } from "../preferences";
import type { State } from "../state";

/** Ends the welcome once the user has driven; `keep` stores that on this device. */
export function listenFirstDrive(
  state: State,
  keep: (change: Partial<Preferences>) => void,
): () => void {
  return effect(() => {
    const drives = state.mayMove.value && isMoving(state.motion.value);
    if (drives && !state.preferences.peek().welcomed) keep({ welcomed: true });
  });
}
