import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { canLeavePage, comeBack, isApart, leavePage, watchApart } from "../pictureInPicture";
import { type Code, t } from "../words/words";
import { useSession, useState } from "./context";
import { isLive } from "./live";

/**
 * Shows the large picture in a window of its own. Nothing can be drawn over it there, so it returns
 * as soon as it is not live, or the host has switched it off.
 */
export function PictureInPicture() {
  const session = useSession();
  const { isBlanked, preferences, large } = useState();
  const apart = useSignal<HTMLVideoElement | null>(null);
  const told = useSignal<Code | null>(null);
  const mayBeApart = isLive(session.state) && !isBlanked.value && preferences.value.picture;
  const shown = large.value;

  useEffect(() => {
    const video = apart.value;
    if (!video) return;
    return watchApart(video, () => {
      if (!isApart(video)) apart.value = null;
    });
  }, [apart.value, apart]);

  useEffect(() => {
    const video = apart.peek();
    if (!video || (mayBeApart && video === session.shownPicture())) return;
    if (!mayBeApart) told.value = "watch.pip.left";
    void comeBack(video).catch(() => {});
  }, [mayBeApart, shown, apart, told, session]);

  useEffect(
    () => () => {
      const video = apart.peek();
      if (video) void comeBack(video).catch(() => {});
    },
    [apart],
  );

  if (!canLeavePage()) return null;
  const toggle = async () => {
    told.value = null;
    const video = apart.peek() ?? session.shownPicture();
    try {
      if (apart.peek() && video) await comeBack(video);
      else if (video) {
        await leavePage(video);
        apart.value = video;
      }
    } catch {
      told.value = "watch.pip.refused";
    }
  };
  return (
    <div class="watch-act">
      <button
        type="button"
        class="plain-button"
        disabled={!apart.value && !mayBeApart}
        onClick={() => void toggle()}
      >
        {t(apart.value ? "watch.pip.back" : "watch.pip")}
      </button>
      {told.value && (
        <p role="alert" class="quiet">
          {t(told.value)}
        </p>
      )}
    </div>
  );
}
