import { useEffect, useRef } from "preact/hooks";
import { tellsFrames } from "../measure/picture";
import { said } from "../words/said";
import { t } from "../words/words";
import { CallCard } from "./CallCard";
import { useActions, useSession, useState } from "./context";
import { msWords } from "./figures";
import { Hud } from "./Hud";
import { CurtainIcon, EarIcon, MutedIcon } from "./icons";
import { isStale } from "./live";
import { blanked, problemWords, silenceWords } from "./pageWords";
import { Toast } from "./Toast";
import { Views } from "./Views";

/** The picture, and the messages over it. */
export function Picture() {
  const session = useSession();
  const { preferences, isBlanked, isConnected, isSilent } = session.state;
  const video = useRef<HTMLVideoElement>(null);
  const audio = useRef<HTMLAudioElement>(null);
  const section = useRef<HTMLElement>(null);
  useEffect(() => {
    session.attachPicture(video.current);
    session.attachSound(audio.current);
    return () => {
      session.attachPicture(null);
      session.attachSound(null);
    };
  }, [session]);

  const isOn = preferences.value.picture;
  const isShown = isOn && !isBlanked.value;
  useEffect(
    () => (video.current && section.current ? shape(section.current, video.current) : undefined),
    [],
  );
  const isLive = isConnected.value && !isSilent.value && !isStale(session.state);
  return (
    <section
      ref={section}
      class={isLive ? "picture" : "picture is-greyed"}
      aria-label={t("picture.name")}
    >
      <Views isShown={isShown} video={video} />
      {/* biome-ignore lint/a11y/useMediaCaption: a live robot has no captions */}
      <audio ref={audio} />
      {isBlanked.value ? <Blanked /> : !isOn && <PictureOff />}
      <Unconnected />
      <Hud />
      <div class="picture-foot">
        <Warnings />
        <Slowness />
        <SoundOffer />
        <Toast />
      </div>
      <CallCard />
    </section>
  );
}

/** Gives the section the picture's aspect ratio, so that there are no black bars. */
function shape(section: HTMLElement, video: HTMLVideoElement): () => void {
  const follow = () => {
    const { videoWidth, videoHeight } = video;
    if (videoWidth === 0) return;
    section.style.setProperty("--aspect", `${videoWidth / videoHeight}`);
    // What is below the picture is as wide.
    section.parentElement?.style.setProperty("--shape", `${videoWidth / videoHeight}`);
  };
  follow();
  video.addEventListener("resize", follow);
  return () => video.removeEventListener("resize", follow);
}

function PictureOff() {
  return (
    <div class="picture-off">
      <EarIcon />
      <p>{t("picture.off")}</p>
      <p class="quiet">{t("picture.by_ear")}</p>
    </div>
  );
}

/** Shown while the host has switched picture and sound off. */
function Blanked() {
  return (
    <div class="picture-off" role="status" aria-label={t("picture.name")}>
      <CurtainIcon />
      <p>{blanked()}</p>
    </div>
  );
}

/** Shown without a connection: why it takes a while, and where else the robot can be watched. */
function Unconnected() {
  const { hello, link, links, isConnected } = useState();
  const reason =
    link.value.is === "connecting" || link.value.is === "waiting" ? link.value.reason : null;
  if (links.value.length > 0 && !isConnected.value) {
    return (
      <div class="picture-off">
        <p>{t("picture.no_place")}</p>
        {links.value.map((url) => (
          <a key={url} href={url} dir="ltr" rel="noreferrer">
            {url}
          </a>
        ))}
      </div>
    );
  }
  if (hello.value || reason === null) return null;
  return (
    <div class="picture-off">
      <p>{said(reason)}</p>
      <p class="quiet">{t("picture.tries_again")}</p>
    </div>
  );
}

/** The button that starts the sound, which no browser plays before a press. */
function SoundOffer() {
  const { isStartOffered, isBlanked, hello, drivingTurn } = useState();
  const { start } = useActions();
  const isOver = isBlanked.value || silenceWords(hello.value) !== null;
  // The operator has the switch instead, and keeps the picture free.
  if (!isStartOffered.value || isOver || drivingTurn.value !== null) return null;
  return (
    <button type="button" class="sound-offer" onClick={start}>
      <MutedIcon />
      {t("hud.sound_on")}
    </button>
  );
}

function Warnings() {
  const state = useState();
  const { room, facts, isConnected, isSilent, preferences, drivingTurn } = state;
  const isOn = preferences.value.picture;
  const isOld = isConnected.value && !isSilent.value && isOn && isStale(state);
  const isBlind = drivingTurn.value !== null && isOn && !tellsFrames();
  const problems = isConnected.value ? problemWords(room.value) : [];
  return (
    <ul class="warnings" aria-live="polite" aria-label={t("picture.problems")}>
      {problems.map((problem) => (
        <li key={problem}>{problem}</li>
      ))}
      {isSilent.value && isOn && <li>{t("picture.silent")}</li>}
      {isBlind && <li>{t("picture.blind")}</li>}
      {isOld && problems.length === 0 && (
        <li>
          <span aria-hidden="true">
            {t("picture.old", { age: msWords(facts.value.pictureMs) })}
          </span>
          {/* Every new figure would be read out. */}
          <span class="visually-hidden">{t("picture.not_live")}</span>
        </li>
      )}
    </ul>
  );
}

/** Not a problem: the reason why picture and sound are not in step. */
function Slowness() {
  const { served, isConnected } = useState();
  const isSlow = isConnected.value && served.value?.in_step === false;
  return (
    <p class="slowness" aria-live="polite">
      {isSlow && t("picture.slow")}
    </p>
  );
}
