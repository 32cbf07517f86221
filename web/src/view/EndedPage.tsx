import type { Ended } from "../messages";
import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { whenWords } from "./words";

/** Instead of everything else: why this page may not stay, and what to do. */
export function EndedPage({ ended }: { ended: Ended }) {
  const { comeBack } = useActions();
  const { entryProblem } = useState();
  const opensMs = ended.opens_wall_ms;
  return (
    <main class="ended">
      <p class="brand">WAX</p>
      <div role="alert">
        <h1>{said(ended.text)}</h1>
      </div>
      {entryProblem.value && <p>{said(entryProblem.value)}</p>}
      {opensMs !== null && <p>{t("link.opens", { when: whenWords(opensMs, Date.now()) })}</p>}
      <button type="button" class="ended-button" onClick={comeBack}>
        {t("link.come_back")}
      </button>
    </main>
  );
}
