import "../bigScreen/bigScreen.css";
import "./embed.css";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Session } from "../actions";
import { joinAddress } from "../bigScreen/facts";
import { Picture, problemOf, Who } from "../bigScreen/parts";
import { keepRunning } from "../bigScreen/unattended";
import { SessionContext, useSession, useState } from "../view/context";
import { silenceWords } from "../view/pageWords";
import { robotName } from "../view/robotName";
import { said } from "../words/said";
import { t } from "../words/words";

/** For a frame on another site: the picture, who drives, how many wait, and a link to the page. */
export function Embed({ session }: { session: Session }) {
  useEffect(() => keepRunning(session), [session]);
  const { hello } = session.state;
  return (
    <SessionContext.Provider value={session}>
      <main class="big-screen embed">
        <h1 class="visually-hidden">{robotName(hello.value)}</h1>
        <Picture />
        <Problem />
        <div class="big-screen-foot">
          <Robot />
          <div class="embed-acts">
            <Sound />
            <Way mayQueue={hello.value?.may_queue === true} />
          </div>
        </div>
      </main>
    </SessionContext.Provider>
  );
}

export { Embed as View };

/** Why the picture is not live, in the server's words if it refused. */
function Problem() {
  const state = useState();
  const link = state.link.value;
  const isRefused = link.is === "waiting" && !state.ended.value;
  return (
    <p class="big-screen-problem" role="status">
      {isRefused ? said(link.reason) : problemOf(state)}
    </p>
  );
}

function Robot() {
  const { room, isConnected } = useState();
  if (!room.value || !isConnected.value) return null;
  const n = room.value.viewers.filter((one) => one.role === "queued").length;
  return (
    <section class="big-screen-driver" aria-live="polite">
      <Who />
      <p>{t(n > 0 ? "embed.waiting" : "big_screen.next.nobody", { n })}</p>
    </section>
  );
}

/** A link to the page; once pressed, its address to copy, as a frame may not open a tab. */
function Way({ mayQueue }: { mayQueue: boolean }) {
  const isPressed = useSignal(false);
  const address = joinAddress(window.location);
  const press = () => {
    isPressed.value = true;
  };
  return (
    <a href={address} target="_blank" rel="noopener" onClick={press}>
      {isPressed.value ? address : t(mayQueue ? "embed.drive" : "embed.open")}
    </a>
  );
}

/** The sound, off until the button is pressed, as browsers demand. */
function Sound() {
  const session = useSession();
  const { isSoundOn, hello } = useState();
  const audio = useRef<HTMLAudioElement>(null);
  useEffect(() => {
    session.attachSound(audio.current);
    return () => session.attachSound(null);
  }, [session]);
  const isOffered = hello.value !== null && silenceWords(hello.value) === null;
  return (
    <>
      {/* biome-ignore lint/a11y/useMediaCaption: a live robot has no captions */}
      <audio ref={audio} />
      {isOffered && (
        <button type="button" onClick={() => session.actions.setSound(!isSoundOn.value)}>
          {t(isSoundOn.value ? "watch.mute" : "hud.sound_on")}
        </button>
      )}
    </>
  );
}
