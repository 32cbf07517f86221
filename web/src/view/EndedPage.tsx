import type { Ended } from "../messages";
import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { late } from "./late";
import { whenWords } from "./pageWords";

export const Hours = late(async () => (await import("./Hours")).Hours);

/** The page for a user who may not stay: why, and what to do. */
export function EndedPage({ ended }: { ended: Ended }) {
  const { comeBack } = useActions();
  const { entryProblem } = useState();
  const [next] = ended.openings;
  return (
    <main class="ended">
      <p class="brand">WAX</p>
      <div role="alert">
        <h1>{said(ended.text)}</h1>
      </div>
      {entryProblem.value && <p>{said(entryProblem.value)}</p>}
      {next && <p>{t("link.opens", { when: whenWords(next.opens_wall_ms, Date.now()) })}</p>}
      {next && <Hours openings={ended.openings} />}
      <button type="button" class="ended-button" onClick={comeBack}>
        {t("link.come_back")}
      </button>
    </main>
  );
}
