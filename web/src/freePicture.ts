import type { State } from "./state";

/** A phone held across: what opens there lies over the picture. */
const ACROSS = "(orientation: landscape) and (max-height: 559px)";

/** Keeps the picture free where an open panel would cover it: at first, and when a turn begins. */
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
