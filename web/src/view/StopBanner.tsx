import { useActions, useState } from "./context";
import { HoldButton } from "./HoldButton";
import { stoppedWords } from "./words";

/** Over the picture, for everybody: who stopped the robot, and who can release the stop. */
export function StopBanner() {
  const { room, me, mayRelease } = useState();
  const { releaseStop } = useActions();
  const stop = room.value?.stop;
  if (!stop) return null;
  const { headline, next } = stoppedWords(room.value, stop, me.value, mayRelease.value);
  return (
    <div class="stopped">
      <div class="stopped-words" role="alert">
        <p class="stopped-by">{headline}</p>
        <p>{next}</p>
      </div>
      {mayRelease.value && <HoldButton onHeld={releaseStop}>Hold to release</HoldButton>}
    </div>
  );
}
