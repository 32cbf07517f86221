/** Draws the turn's card and the tab's title; what the card says and offers: `face.ts`. */

import { useEffect } from "preact/hooks";
import { isThin } from "../link/thin";
import { alertTab } from "../tabIcon";
import { canNotify } from "../turnNotification";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { ENDING_S, type Face, faceOf } from "./face";
import { HoldButton } from "./HoldButton";
import { robotName } from "./robotName";
import { Switch } from "./Switch";

/** The state, the time left, and the one obvious next step. */
export function TurnCard() {
  const state = useState();
  const { releaseStop } = useActions();
  const isConnected = state.isConnected.value;
  const isDriving = state.drivingTurn.value !== null;
  const seconds = isConnected ? state.secondsLeft.value : null;
  const now = faceOf(state);
  const isUrgent = isDriving || now.tone === "stopped";
  return (
    <section class={`turn is-${now.tone}`} aria-label={t("face.turn")}>
      <TabTitle />
      <div class="turn-words" aria-live={isUrgent ? "assertive" : "polite"}>
        <p class="headline">{now.headline}</p>
        <p class="next">{now.next}</p>
        {now.note && <p class="turn-note">{now.note}</p>}
        {/* The timer is not read out, nor is its colour. */}
        {now.tone === "ending" && (
          <p class="visually-hidden">{t("face.ending", { n: ENDING_S })}</p>
        )}
      </div>
      <Clock wait={now.wait} secondsLeft={seconds} />
      {now.releases && <HoldButton onHeld={releaseStop}>{t("face.release")}</HoldButton>}
      <QueueButton does={now.queue} />
      <Disown />
      {now.queue === "leave" && <TellMe />}
    </section>
  );
}

/** The time left, or the estimated wait; not read out, as it changes again and again. */
function Clock({ wait, secondsLeft }: { wait: string | null; secondsLeft: number | null }) {
  const left = secondsLeft === null ? "" : t("face.left", { n: secondsLeft });
  return (
    <div class="timer" role="timer" aria-label={t(wait === null ? "face.time_left" : "face.wait")}>
      {wait ?? left}
    </div>
  );
}

function QueueButton({ does }: { does: Face["queue"] }) {
  const { join, leave } = useActions();
  if (does === null) return null;
  // The keys prevent a reused button from keeping the focus, by which Space would leave.
  if (does === "join") {
    return (
      <button key="join" type="button" class="queue-button" onClick={join}>
        {t("face.join")}
      </button>
    );
  }
  // Ignore the second click of a double-click on Join.
  const onClick = (event: MouseEvent) => {
    if (event.detail < 2) leave();
  };
  return (
    <button key={does} type="button" class="queue-button is-leave" onClick={onClick}>
      {t(does === "end" ? "face.end" : "face.leave")}
    </button>
  );
}

/** Takes the turn that has just ended out of what the recording is used for. */
function Disown() {
  const { room, drivenTurn } = useState();
  const { disown } = useActions();
  if (!room.value?.tape?.can_disown || drivenTurn.value === null) return null;
  return (
    <button type="button" class="plain-button" onClick={disown}>
      {t("tape.disown")}
    </button>
  );
}

/** The switch for a notification at one's turn; only where the browser has notifications. */
function TellMe() {
  const { preferences } = useState();
  const { tellMe } = useActions();
  if (!canNotify()) return null;
  const isOn = preferences.value.tells && Notification.permission === "granted";
  return <Switch name={t("face.tell_me")} isOn={isOn} onSwitch={tellMe} />;
}

/** Shows in the tab's title and icon when the user is wanted. */
function TabTitle() {
  const { drivingTurn, callSecondsLeft, me, stopNumber, hello, served } = useState();
  const isDriving = drivingTurn.value !== null;
  const isCalled = callSecondsLeft.value !== null;
  const isNext = me.value?.place === 1;
  const isStopped = stopNumber.value !== null;
  const name = robotName(hello.value);
  const title = isStopped
    ? t("face.title_stopped", { name })
    : isDriving
      ? t("face.title_driving", { name })
      : isCalled
        ? t("face.title_called", { name })
        : isNext
          ? t("face.title_next", { name })
          : name;
  useEffect(() => {
    document.title = title;
  }, [title]);
  // On a thin link not even an icon is loaded beside the sound.
  const isWanted = (isCalled || isDriving) && !(served.value && isThin(served.value));
  useEffect(() => alertTab(document, isWanted), [isWanted]);
  useEffect(() => {
    if (isDriving) navigator.vibrate?.(200);
  }, [isDriving]);
  return null;
}
