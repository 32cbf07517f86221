import type { Presser } from "../../messages";
import { named } from "../../words/named";
import { said } from "../../words/said";
import { t } from "../../words/words";
import { Ask } from "../Ask";
import { useActions, useState } from "../context";

/** Who has pressed Stop lately, by address, as browsers are easy to change; ignores one. */
export function Pressers() {
  const { console } = useState();
  const pressers = console.value?.pressers ?? [];
  if (pressers.length === 0) return null;
  return (
    <section class="host-section" aria-labelledby="pressers-title">
      <h3 id="pressers-title">{t("people.pressers")}</h3>
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ul class="people" role="list">
        {pressers.map((one) => (
          <Line key={one.id} presser={one} />
        ))}
      </ul>
    </section>
  );
}

function Line({ presser }: { presser: Presser }) {
  const { actAsHost } = useActions();
  const mute = (muted: boolean) => () =>
    actAsHost({ type: "mute_address", presser: presser.id, muted });
  return (
    <li class="person">
      <p class="person-head">
        {t("people.pressed", { n: presser.presses, name: named(said(presser.by)) })}{" "}
        <bdi class="quiet">{presser.address}</bdi>
      </p>
      <div class="person-buttons">
        {presser.muted ? (
          <button type="button" class="plain-button" onClick={mute(false)}>
            {t("people.heed_address")}
          </button>
        ) : (
          <Ask
            name={t("people.ignore_address")}
            question={t("people.ignore_question")}
            answers={{ [t("people.ignore")]: mute(true) }}
          />
        )}
      </div>
    </li>
  );
}
