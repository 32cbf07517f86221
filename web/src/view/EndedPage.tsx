import type { Ended, Opening } from "../messages";
import { said } from "../words/said";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { openingWords, whenWords } from "./words";

/** Instead of everything else: why this page may not stay, and what to do. */
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

/** A week of opening hours as a clock here shows them, and as a calendar to take along. */
function Hours({ openings }: { openings: readonly Opening[] }) {
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  return (
    <>
      <p id="ended-hours">{t("link.hours", { zone })}</p>
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ul role="list" aria-labelledby="ended-hours">
        {openings.map((one) => (
          <li key={one.opens_wall_ms}>{openingWords(one)}</li>
        ))}
      </ul>
      <a href="open.ics">{t("link.calendar")}</a>
    </>
  );
}
