import type { ComponentChildren } from "preact";
import { PLAYERS, type Preferences } from "../preferences";
import { useActions, useState } from "../view/context";
import {
  ageWords,
  breakWords,
  linkWords,
  msWords,
  reasons,
  sentPictureWords,
  sentSoundWords,
  skewWords,
} from "../view/figures";
import { batteryWords } from "../view/words";
import { type Code, t } from "../words/words";

/** How old picture and sound are, how well they play, what is sent, and why. */
export function Figures() {
  const { facts, served, playout, player, room } = useState();
  const { pictureMs, pictureErrorMs, soundMs, skewMs, roundTripMs, fps } = facts.value;
  const { pauses, freezes } = facts.value;
  const battery = room.value && batteryWords(room.value.robot);
  const sentences = reasons(playout.value, served.value, player.value);
  return (
    <dl class="stats-figures">
      <Figure name="picture_age">{ageWords(pictureMs, pictureErrorMs)}</Figure>
      {/* The age runs from when the server receives a picture to when the browser presents it. */}
      {pictureMs !== null && (
        <Figure name="not_included">{t("stats.figure.not_included.what")}</Figure>
      )}
      <Figure name="sound_age">{msWords(soundMs)}</Figure>
      <Figure name="skew">{skewWords(skewMs)}</Figure>
      <Figure name="round_trip">{msWords(roundTripMs)}</Figure>
      <Figure name="fps">{fps === null ? "–" : t("stats.figure.fps.value", { fps })}</Figure>
      <Figure name="pauses">{breakWords(pauses)}</Figure>
      <Figure name="freezes">{breakWords(freezes)}</Figure>
      <Figure name="policy">{playout.value?.policy ?? "–"}</Figure>
      <Figure name="picture_sent">{sentPictureWords(served.value)}</Figure>
      <Figure name="sound_sent">{sentSoundWords(served.value)}</Figure>
      <Figure name="player">{t(`stats.figure.player.${player.value.by}`)}</Figure>
      <Player />
      <Figure name="link">{linkWords(served.value)}</Figure>
      {battery && <Figure name="battery">{battery}</Figure>}
      {sentences.length > 0 && <dt>{t("stats.figure.why")}</dt>}
      {sentences.map((sentence) => (
        <dd key={sentence} class="reason">
          {sentence}
        </dd>
      ))}
    </dl>
  );
}

/** Which player plays the sound, for who wants to compare them. */
function Player() {
  const { preferences } = useState();
  const { setPlayer } = useActions();
  return (
    <>
      <dt id="stats-player">{t("stats.figure.play_by")}</dt>
      <dd>
        <select
          aria-labelledby="stats-player"
          value={preferences.value.player ?? ""}
          onChange={(event) =>
            setPlayer((event.currentTarget.value || null) as Preferences["player"])
          }
        >
          {PLAYERS.map((one) => (
            <option key={one} value={one ?? ""}>
              {t(`stats.figure.play_by.${one ?? "automatic"}`)}
            </option>
          ))}
        </select>
      </dd>
    </>
  );
}

type Name<C> = C extends `stats.figure.${infer N}` ? N : never;

function Figure({ name, children }: { name: Name<Code>; children: ComponentChildren }) {
  return (
    <>
      <dt>{t(`stats.figure.${name}`)}</dt>
      <dd>{children}</dd>
    </>
  );
}
