/** When, and how long, the page thanks a user for driving; what it says: `view/face.ts`. */

import type { State } from "./state";

const THANKS_MS = 12_000;
/** How long the page offers to disown a turn; the server accepts it for twice as long. */
const DISOWN_MS = 60_000;

/**
 * Shows for a while that this viewer's turn is over, unless a lost connection ended it. In both cases
 * the turn can be disowned for a while.
 */
export function listenTurnOver(state: State): void {
  let driven: number | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let disowning: ReturnType<typeof setTimeout> | undefined;
  const tell = (isOver: boolean) => {
    clearTimeout(timer);
    state.isTurnJustOver.value = isOver;
    if (isOver) timer = setTimeout(() => tell(false), THANKS_MS);
  };
  state.drivingTurn.subscribe((turn) => {
    const isOver = driven !== null && turn === null && state.isConnected.peek();
    if (turn !== null) tell(false);
    else if (isOver) tell(true);
    if (driven !== null || turn !== null) {
      clearTimeout(disowning);
      state.drivenTurn.value = turn === null ? driven : null;
      disowning = setTimeout(() => {
        state.drivenTurn.value = null;
      }, DISOWN_MS);
    }
    driven = turn;
  });
}
