import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";

/** Tells everybody that they are recorded and, opened, why; some may keep the recording. */
export function TapeBadge() {
  const { room, mayKeepTape } = useState();
  const { keepTape } = useActions();
  const tape = room.value?.tape;
  if (!tape) return null;
  return (
    <details class={tape.running ? "tape is-running" : "tape"}>
      <summary>{tape.running ? t("tape.recorded") : t("tape.not_recorded")}</summary>
      <div class="tape-why">
        <p>{said(tape.why)}</p>
        {mayKeepTape.value && (
          <button type="button" class="plain-button" onClick={keepTape}>
            {t("tape.keep")}
          </button>
        )}
      </div>
    </details>
  );
}
