import type { State } from "./state";

/** A phone in landscape, where panels open over the picture. */
const ACROSS = "(orientation: landscape) and (max-height: 559px)";

/** Closes a panel that would cover the picture: at the start, and when a turn begins. */
export function freePicture(window: Window, state: State, signal: AbortSignal): void {
  const across = window.matchMedia(ACROSS);
  const clear = () => {
    if (across.matches) state.panel.value = null;
  };
  clear();
  across.addEventListener("change", clear, { signal });
  state.drivingTurn.subscribe((turn) => {
    if (turn !== null) clear();
  });
}
