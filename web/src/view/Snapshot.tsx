import { useSignal } from "@preact/signals";
import { download } from "../download";
import { photoName, pictureOf } from "../snapshot";
import type { State } from "../state";
import { type Code, t } from "../words/words";
import { useSession } from "./context";
import { isLive } from "./live";
import { robotName } from "./robotName";

/** Why no photo can be taken; null if one can. */
export function whyNoPhoto(state: State, video: HTMLVideoElement | null): Code | null {
  if (state.isBlanked.value) return "watch.snapshot.blanked";
  if (!state.preferences.value.picture) return "watch.snapshot.off";
  if (!video || video.videoWidth === 0) return "watch.snapshot.none";
  return isLive(state) ? null : "watch.snapshot.old";
}

/** Saves the current picture, only while it is live. */
export function Snapshot() {
  const session = useSession();
  const why = useSignal<Code | null>(null);
  const take = async () => {
    const video = session.shownPicture();
    why.value = whyNoPhoto(session.state, video);
    if (why.value !== null || !video) return;
    const photo = await session.forPhoto(() => pictureOf(video)).catch(() => null);
    if (photo) download(photo, photoName(robotName(session.state.hello.peek()), new Date()));
    else why.value = "watch.snapshot.failed";
  };
  return (
    <div class="watch-act">
      <button type="button" class="plain-button" onClick={() => void take()}>
        {t("watch.snapshot")}
      </button>
      {why.value && (
        <p role="alert" class="quiet">
          {t(why.value)}
        </p>
      )}
    </div>
  );
}
