import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import {
  enterFullscreen,
  enterVideoFullscreen,
  hasFullscreen,
  hasVideoFullscreen,
  isFullscreen,
  leaveFullscreen,
  watchFullscreen,
} from "../fullscreen";
import { t } from "../words/words";
import { useSession, useState } from "./context";

/** A button for fullscreen with everything over the picture; hidden where that is not possible. */
export function Fullscreen() {
  const session = useSession();
  const { drivingTurn } = useState();
  const isOn = useSignal(isFullscreen());
  const isRefused = useSignal(false);
  useEffect(
    () =>
      watchFullscreen(() => {
        isOn.value = isFullscreen();
        if (isOn.value) isRefused.value = false;
      }),
    [isOn, isRefused],
  );
  const isWhole = hasFullscreen();
  // A video alone in fullscreen has no Stop over it, so it is not for the operator.
  const isVideo = !isWhole && drivingTurn.value === null;
  if (!isWhole && !(isVideo && hasVideoFullscreen(session.shownPicture()))) return null;

  const toggle = async () => {
    try {
      if (isOn.peek()) await leaveFullscreen();
      else if (isWhole) await enterFullscreen();
      else {
        const video = session.shownPicture();
        if (video) enterVideoFullscreen(video);
      }
    } catch {
      isRefused.value = true;
    }
  };
  return (
    <div class="watch-act">
      <button type="button" class="plain-button" onClick={() => void toggle()}>
        {t(isOn.value ? "watch.fullscreen.leave" : "watch.fullscreen")}
      </button>
      {isRefused.value && (
        <p role="alert" class="quiet">
          {t("watch.fullscreen.refused")}
        </p>
      )}
    </div>
  );
}
