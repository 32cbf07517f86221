import { useEffect, useRef } from "preact/hooks";
import { t } from "../words/words";
import { useActions, useState } from "./context";

const OPERABLE = "input, select, textarea, button, a[href], summary";

/** Asks the next in the queue whether they are ready; any touch or key on the card confirms. */
export function CallCard() {
  const { callSecondsLeft } = useState();
  const { answerCall } = useActions();
  const button = useRef<HTMLButtonElement>(null);
  const seconds = callSecondsLeft.value;
  const isCalled = seconds !== null;
  useEffect(() => {
    if (!isCalled) return;
    navigator.vibrate?.([200, 100, 200]);
    // Do not take the focus from a text field or another control.
    if (!document.activeElement?.matches(OPERABLE)) button.current?.focus();
  }, [isCalled]);
  if (!isCalled) return null;
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the button in it takes every key
    <section class="call" role="alertdialog" aria-labelledby="call-words" onClick={answerCall}>
      <p class="call-words" id="call-words">
        {t("turn.called")}
      </p>
      <button
        ref={button}
        type="button"
        class="call-button"
        onKeyDown={(event) => {
          if (event.key === "Tab" || event.repeat) return;
          event.preventDefault();
          answerCall();
        }}
      >
        {t("turn.ready")}
      </button>
      <p class="call-left" role="timer" aria-label={t("turn.time_to_answer")}>
        {t("turn.left_to_answer", { seconds: String(seconds) })}
      </p>
    </section>
  );
}
