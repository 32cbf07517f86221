import { useSignal } from "@preact/signals";
import { t } from "../words/words";

interface Props {
  /** What the button does, and what it says when asking. */
  name: string;
  question: string;
  /** Further answers that act, by their words. */
  answers: Record<string, () => void>;
}

/** A button for what cannot be taken back: it asks once, in its own place. */
export function Ask({ name, question, answers }: Props) {
  const isAsking = useSignal(false);
  const close = () => {
    isAsking.value = false;
  };
  if (!isAsking.value) {
    return (
      <button
        type="button"
        class="plain-button"
        onClick={() => {
          isAsking.value = true;
        }}
      >
        {name}
      </button>
    );
  }
  return (
    <fieldset class="ask" aria-label={question}>
      <p role="alert">{question}</p>
      <div class="ask-answers">
        {Object.entries(answers).map(([words, act]) => (
          <button
            key={words}
            type="button"
            class="danger-button"
            onClick={() => {
              close();
              act();
            }}
          >
            {words}
          </button>
        ))}
        <button type="button" class="plain-button" onClick={close}>
          {t("host.cancel")}
        </button>
      </div>
    </fieldset>
  );
}
