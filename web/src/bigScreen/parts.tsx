/** What a big screen and a frame on another site both show. */

import { useEffect, useRef } from "preact/hooks";
import type { State } from "../state";
import { useSession, useState } from "../view/context";
import { isLive } from "../view/live";
import { named } from "../words/named";
import { said } from "../words/said";
import { t } from "../words/words";

export function Picture() {
  const session = useSession();
  const { isBlanked } = useState();
  const video = useRef<HTMLVideoElement>(null);
  useEffect(() => {
    session.attachPicture(video.current);
    return () => session.attachPicture(null);
  }, [session]);
  const kinds = [
    "big-screen-picture",
    ...(isLive(session.state) ? [] : ["is-greyed"]),
    ...(isBlanked.value ? ["is-off"] : []),
  ];
  return <video ref={video} class={kinds.join(" ")} muted autoplay playsinline />;
}

/** Why the picture is not live; null if it is. */
export function problemOf(state: State): string | null {
  const { link, isConnected, isSilent, ended, isBlanked, room } = state;
  if (ended.value) return said(ended.value.text);
  if (link.value.is === "connecting" && link.value.reason === null)
    return t("big_screen.connecting");
  if (!isConnected.value || isSilent.value) return t("big_screen.lost");
  if (isBlanked.value) return t("big_screen.blanked");
  if (room.value?.video.problem) return t("big_screen.no_picture");
  return isLive(state) ? null : t("big_screen.old");
}

/** Who drives. */
export function Who() {
  const { room, operator } = useState();
  return (
    <p class="big-screen-who">
      {operator.value
        ? t("big_screen.driving", { name: named(operator.value.name) })
        : t(room.value?.host_settings.held ? "big_screen.closed" : "big_screen.free")}
    </p>
  );
}
