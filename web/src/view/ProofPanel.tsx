import { useSignal } from "@preact/signals";
import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";

/** In the host's panel: starts the proof, which measures how fast the real robot stops. */
export function ProofPanel() {
  const { proof } = useState();
  const { pollProof, prove } = useActions();
  const isLifted = useSignal(false);
  const isRunning = proof.value?.state === "running";
  const start = () => {
    isLifted.value = false;
    prove();
  };
  return (
    <details
      class="section"
      onToggle={(event) => {
        if (event.currentTarget.open) pollProof();
      }}
    >
      <summary>{t("proof.title")}</summary>
      <div class="section-body">
        <p>{t("proof.what")}</p>
        <label class="check">
          <input
            type="checkbox"
            checked={isLifted.value}
            disabled={isRunning}
            onChange={(event) => {
              isLifted.value = event.currentTarget.checked;
            }}
          />
          <span>{t("proof.lifted")}</span>
        </label>
        <button
          type="button"
          class="main-button"
          disabled={!isLifted.value || isRunning}
          onClick={start}
        >
          {t("proof.begin")}
        </button>
        <Progress />
      </div>
    </details>
  );
}

function Progress() {
  const { proof } = useState();
  const { line = null, record = null } = proof.value ?? {};
  return (
    <>
      <p class="proof-line" role="status" aria-label={t("proof.progress")}>
        {said(line)}
      </p>
      {record && (
        <a href={record} target="_blank" rel="noreferrer">
          {t("proof.record")}
        </a>
      )}
    </>
  );
}
