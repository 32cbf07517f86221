import { useSignal } from "@preact/signals";
import { t } from "../words/words";

interface Props {
  /** What the button does, and what it asks. */
  name: string;
  question: string;
  /** The answers that act, by their text. */
  answers: Record<string, () => void>;
}

/** A button for an irreversible action: it asks for confirmation in place. */
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
