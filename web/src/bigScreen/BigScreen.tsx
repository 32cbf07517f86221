import "./bigScreen.css";
import { signal, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import type { Session } from "../actions";
import { SessionContext, useSession, useState } from "../view/context";
import { robotName } from "../view/robotName";
import { StopAlarm } from "../view/StopAlarm";
import { StopButton } from "../view/StopButton";
import { Toast } from "../view/Toast";
import { keepAwake } from "../wakeLock";
import { named } from "../words/named";
import { said } from "../words/said";
import { t } from "../words/words";
import { clockWords, isOnlyHere, joinAddress, wantsSound, watchers } from "./facts";
import { watchIdle } from "./idle";
import { Picture, problemOf, Who } from "./parts";
import { QrCode } from "./QrCode";
import { keepRunning } from "./unattended";

/** For a screen in a hall: the picture, who drives, who is next, and how to join. */
export function BigScreen({ session }: { session: Session }) {
  const idle = useMemo(() => watchIdle(window), []);
  useEffect(() => {
    const end = keepRunning(session);
    const sleep = keepAwake(signal(true));
    return () => {
      end();
      sleep();
      idle.end();
    };
  }, [session, idle]);
  return (
    <SessionContext.Provider value={session}>
      <main class={idle.isIdle.value ? "big-screen is-idle" : "big-screen"}>
        <Picture />
        <header class="big-screen-head">
          <h1>{robotName(session.state.hello.value)}</h1>
        </header>
        <Problem />
        <div class="big-screen-foot">
          <Driver />
          <Join />
        </div>
        <Sound />
        <div class="big-screen-stop">
          <StopButton />
        </div>
        <div class="big-screen-toasts">
          <StopAlarm />
          <Toast />
        </div>
      </main>
    </SessionContext.Provider>
  );
}

export { BigScreen as View };

/** Why the picture is not live. */
function Problem() {
  return (
    <p class="big-screen-problem" role="status">
      {problemOf(useState())}
    </p>
  );
}

/** Who drives and for how long, who is next, and how many watch. */
function Driver() {
  const { room, secondsLeft, hello, watching, isConnected } = useState();
  const now = room.value;
  if (!now || !isConnected.value) return null;
  const next = now.viewers.find((one) => one.place === 1);
  const isStanding = now.turn.stands_left_ms !== null;
  const count = watchers(now, hello.value?.viewer, watching.value);
  return (
    <section class="big-screen-driver" aria-live="polite">
      <Who />
      {secondsLeft.value !== null && (
        <p
          class="big-screen-timer"
          role="timer"
          aria-live="off"
          aria-label={t("big_screen.time_left")}
        >
          {clockWords(secondsLeft.value)}
        </p>
      )}
      {now.stop && (
        <p class="big-screen-stopped">{t("big_screen.stopped", { name: said(now.stop.by) })}</p>
      )}
      {isStanding && <p>{t("big_screen.stands")}</p>}
      <p>{next ? t("big_screen.next", { name: named(next.name) }) : t("big_screen.next.nobody")}</p>
      {count > 0 && <p class="big-screen-count">{t("big_screen.watching", { n: count })}</p>}
    </section>
  );
}

/** The page's own address, to be opened by a phone. */
function Join() {
  const { hello } = useState();
  const address = joinAddress(window.location);
  if (isOnlyHere(window.location.hostname)) {
    return <p class="big-screen-join is-only-here">{t("big_screen.address", { address })}</p>;
  }
  const mayQueue = hello.value?.may_queue !== false;
  return (
    <section class="big-screen-join">
      <QrCode address={address} />
      <p>{t(mayQueue ? "big_screen.join" : "big_screen.join.watch")}</p>
      <p class="big-screen-address">{address}</p>
    </section>
  );
}

/** Plays the sound if the address asks for it, as soon as the browser allows. */
function Sound() {
  const session = useSession();
  const { player } = useState();
  const audio = useRef<HTMLAudioElement>(null);
  const isHeard = useSignal(false);
  const isWanted = wantsSound(window.location.search);
  useEffect(() => {
    const element = audio.current;
    if (!isWanted || !element) return;
    session.attachSound(element);
    session.actions.setSound(true);
    const leaving = new AbortController();
    const { signal } = leaving;
    element.addEventListener(
      "playing",
      () => {
        isHeard.value = true;
      },
      { signal },
    );
    // Where the browser refuses, a touch is needed.
    for (const sign of ["pointerdown", "keydown"]) {
      window.addEventListener(
        sign,
        () => {
          if (!isHeard.peek()) session.actions.setSound(true);
        },
        { signal },
      );
    }
    return () => {
      leaving.abort();
      session.attachSound(null);
    };
  }, [session, isWanted, isHeard]);
  if (!isWanted) return null;
  return (
    <>
      {/* biome-ignore lint/a11y/useMediaCaption: a live robot has no captions */}
      <audio ref={audio} />
      {!isHeard.value && player.value.by === "browser" && (
        <p class="big-screen-sound">{t("big_screen.touch_for_sound")}</p>
      )}
    </>
  );
}
