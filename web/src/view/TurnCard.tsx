import { useEffect } from "preact/hooks";
import type { ViewerInfo } from "../messages";
import { useActions, useState } from "./context";
import { lostWords, missedWords, NOT_INVITED, standingWords, turnWords } from "./words";

const ENDING_S = 10;

/** Whose turn it is, the time left, and the buttons to join and leave the queue. */
export function TurnCard() {
  const state = useState();
  const me = state.me.value;
  const isConnected = state.isConnected.value;
  const { headline, next } = isConnected
    ? turnWords(state.room.value, me)
    : lostWords(me, state.hello.value?.grace_s ?? 0);
  const seconds = isConnected ? state.secondsLeft.value : null;
  const isDriving = state.drivingTurn.value !== null;
  const isEnding = isDriving && seconds !== null && seconds <= ENDING_S;

  const isCalled = state.callSecondsLeft.value !== null;
  const note = isConnected
    ? (missedWords(state.missedCall.value) ?? standingWords(state.room.value))
    : null;

  useEffect(() => {
    document.title = isDriving
      ? "You are driving – WAX"
      : isCalled
        ? "Are you ready? – WAX"
        : "WAX";
    if (isDriving) navigator.vibrate?.(200);
  }, [isDriving, isCalled]);

  const look = isEnding ? "turn is-driving is-ending" : isDriving ? "turn is-driving" : "turn";
  return (
    <section class={look} aria-label="Turn">
      <div class="turn-words" aria-live={isDriving ? "assertive" : "polite"}>
        <p class="headline">{headline}</p>
        <p class="next">{next}</p>
        {note && <p class="turn-note">{note}</p>}
      </div>
      <div class="timer" role="timer" aria-label="Time left">
        {seconds !== null && (
          <>
            <span class="seconds">{seconds}</span> s<small>left</small>
          </>
        )}
      </div>
      <QueueButton me={me} />
    </section>
  );
}

function QueueButton({ me }: { me: ViewerInfo | null }) {
  const { isConnected, hello } = useState();
  const { join, leave } = useActions();
  const common = { type: "button", disabled: !me || !isConnected.value } as const;
  if (me?.role === "observer" && hello.value?.may_queue === false) {
    return <p class="queue-button-words quiet">{NOT_INVITED}</p>;
  }
  // Keys, or a reused button would keep the focus, and Space would leave.
  if (!me || me.role === "observer") {
    return (
      <button key="join" class="queue-button" {...common} onClick={join}>
        Join the queue
      </button>
    );
  }
  // Ignore the second click of a double click on Join.
  const onClick = (event: MouseEvent) => {
    if (event.detail < 2) leave();
  };
  return (
    <button key="leave" class="queue-button is-leave" {...common} onClick={onClick}>
      Leave the queue
    </button>
  );
}
