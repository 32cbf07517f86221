/** How long the page thanks whoever has driven, and when; what it says then: `view/face.ts`. */

import type { State } from "./state";

/** How long the page thanks whoever has driven. */
const THANKS_MS = 12_000;

/** Says for a moment that this viewer's turn is over; not where the connection ended it. */
export function listenTurnOver(state: State): void {
  let driven: number | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const tell = (isOver: boolean) => {
    clearTimeout(timer);
    state.isTurnJustOver.value = isOver;
    if (isOver) timer = setTimeout(() => tell(false), THANKS_MS);
  };
  state.drivingTurn.subscribe((turn) => {
    const isOver = driven !== null && turn === null && state.isConnected.peek();
    if (turn !== null) tell(false);
    else if (isOver) tell(true);
    driven = turn;
  });
}
