import type { ConsoleViewer, ViewerInfo } from "../../messages";
import { named } from "../../words/named";
import { t } from "../../words/words";
import { Ask } from "../Ask";
import { useActions, useState } from "../context";
import { inOrder, placeWords } from "../pageWords";
import { qualityWords } from "./qualityWords";

/** Everybody, with what only the host sees of them. */
export function People() {
  const { room, console } = useState();
  const lines = new Map(console.value?.viewers.map((line) => [line.id, line]));
  return (
    <section class="host-section" aria-labelledby="people-title">
      <h3 id="people-title">{t("people.title")}</h3>
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ul class="people" role="list">
        {inOrder(room.value?.viewers ?? []).map((viewer) => (
          <Person key={viewer.id} viewer={viewer} line={lines.get(viewer.id) ?? null} />
        ))}
      </ul>
    </section>
  );
}

function Person({ viewer, line }: { viewer: ViewerInfo; line: ConsoleViewer | null }) {
  const marks = [
    ...(viewer.host ? [t("people.host")] : []),
    ...(line?.invited ? [t("people.invited")] : []),
    ...(line?.muted ? [t("people.stop_muted")] : []),
  ];
  return (
    <li class="person">
      <p class="person-head">
        <bdi class="person-name">{viewer.name}</bdi>
        <span class="quiet"> {placeWords(viewer)}</span>
        {marks.map((mark) => (
          <span key={mark} class="mark">
            {mark}
          </span>
        ))}
      </p>
      {line && (
        <p class="quiet person-link">
          <bdi>{line.address}</bdi>
          {line.address && " · "}
          {qualityWords(line)}
        </p>
      )}
      {!viewer.host && <PersonButtons viewer={viewer} isMuted={line?.muted ?? false} />}
    </li>
  );
}

function PersonButtons({ viewer, isMuted }: { viewer: ViewerInfo; isMuted: boolean }) {
  const { actAsHost } = useActions();
  const remove = (ban: boolean) => () => actAsHost({ type: "remove", viewer: viewer.id, ban });
  const mute = () => actAsHost({ type: "mute", viewer: viewer.id, muted: !isMuted });
  return (
    <div class="person-buttons">
      <button type="button" class="plain-button" onClick={mute}>
        {isMuted ? t("people.unmute_stop") : t("people.mute_stop")}
      </button>
      <Ask
        name={t("people.remove_name")}
        question={t("people.remove_question", { name: named(viewer.name) })}
        answers={{ [t("people.remove")]: remove(false), [t("people.ban")]: remove(true) }}
      />
    </div>
  );
}
