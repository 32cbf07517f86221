/** Who is here, and your name; joining, leaving and ending a turn: `TurnCard.tsx`. */

import { MAX_NAME_CHARS } from "../messages";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { LineField } from "./LineField";
import { inOrder, placeWords, watchingWords } from "./pageWords";

/** Everybody who is here, and your name. */
export function Queue() {
  const { room, hello, watching } = useState();
  return (
    <div class="queue">
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ol class="viewers" role="list" aria-label={t("queue.list")}>
        {inOrder(room.value?.viewers ?? []).map((viewer) => (
          <li key={viewer.id} class={`viewer is-${viewer.role}${viewer.lost ? " is-lost" : ""}`}>
            <bdi class="viewer-name">{viewer.name}</bdi>
            {viewer.id === hello.value?.viewer && <span class="viewer-you"> {t("queue.you")}</span>}
            {viewer.host && <span class="mark">{t("queue.host")}</span>}
            <span class="viewer-place"> {placeWords(viewer)}</span>
          </li>
        ))}
      </ol>
      {watching.value !== null && <p class="quiet">{watchingWords(watching.value)}</p>}
      <NameField />
    </div>
  );
}

function NameField() {
  const { preferences, me } = useState();
  const { setName } = useActions();
  const { name } = preferences.value;
  return (
    <LineField
      label={t("queue.your_name")}
      maxLength={MAX_NAME_CHARS}
      autocomplete="nickname"
      placeholder={name ? "" : (me.value?.name ?? "")}
      value={name}
      onSet={setName}
    />
  );
}
