import { useSignal } from "@preact/signals";
import { useActions, useState } from "./context";

/** In the host's panel: measures on the real robot how fast it stops. */
export function ProofPanel() {
  const { proof } = useState();
  const { lookAtProof, prove } = useActions();
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
        if (event.currentTarget.open) lookAtProof();
      }}
    >
      <summary>Prove the stop…</summary>
      <div class="section-body">
        <p>
          The server cuts each link to the robot in turn while its wheels turn, and measures how
          long they go on. This takes a few minutes, during which nobody can drive. Lift the robot
          off the floor first.
        </p>
        <label class="check">
          <input
            type="checkbox"
            checked={isLifted.value}
            disabled={isRunning}
            onChange={(event) => {
              isLifted.value = event.currentTarget.checked;
            }}
          />
          <span>The wheels are off the floor</span>
        </label>
        <button
          type="button"
          class="main-button"
          disabled={!isLifted.value || isRunning}
          onClick={start}
        >
          Prove it now
        </button>
        <Progress />
      </div>
    </details>
  );
}

function Progress() {
  const { proof } = useState();
  const { line = "", record = null } = proof.value ?? {};
  return (
    <>
      <p class="proof-line" role="status" aria-label="Proof">
        {line}
      </p>
      {record && (
        <a href={record} target="_blank" rel="noreferrer">
          Open the record
        </a>
      )}
    </>
  );
}
