import type { ComponentChildren } from "preact";
import { PLAYERS, type Preferences } from "../preferences";
import { useActions, useState } from "./context";
import {
  ageWords,
  breakWords,
  linkWords,
  msWords,
  reasons,
  sentPictureWords,
  sentSoundWords,
  skewWords,
} from "./figures";
import { batteryWords } from "./words";

/** The picture age runs from when the server receives the frame to when the browser presents it. */
const NOT_IN_PICTURE_AGE = "the camera's own 20–60 ms, your screen's refresh";

/** The delays, and when opened: how well it plays, what is sent, and why. */
export function Facts() {
  const { facts, served, playout, player, room } = useState();
  const { pictureMs, pictureErrorMs, soundMs, skewMs, roundTripMs, fps } = facts.value;
  const { pauses, freezes } = facts.value;
  const battery = room.value && batteryWords(room.value.robot);
  return (
    <dl class="facts">
      <Fact name="Picture age">{ageWords(pictureMs, pictureErrorMs)}</Fact>
      {pictureMs !== null && <Fact name="Not included">{NOT_IN_PICTURE_AGE}</Fact>}
      <Fact name="Sound age">{msWords(soundMs)}</Fact>
      <Fact name="Skew">{skewWords(skewMs)}</Fact>
      <Fact name="Round trip">{msWords(roundTripMs)}</Fact>
      <Fact name="Frame rate">{fps === null ? "–" : `${fps} fps`}</Fact>
      <Fact name="Sound gaps, last minute">{breakWords(pauses)}</Fact>
      <Fact name="Freezes, last minute">{breakWords(freezes)}</Fact>
      <Fact name="Policy">{playout.value?.policy ?? "–"}</Fact>
      <Fact name="Picture sent">{sentPictureWords(served.value)}</Fact>
      <Fact name="Sound sent">{sentSoundWords(served.value)}</Fact>
      <Fact name="Sound player">{player.value.by === "own" ? "WAX's own" : "the browser's"}</Fact>
      <Player />
      <Fact name="Link">{linkWords(served.value)}</Fact>
      {battery && <Fact name="Battery">{battery}</Fact>}
      <Reasons sentences={reasons(playout.value, served.value, player.value)} />
    </dl>
  );
}

const PLAYER_NAMES = { own: "WAX's own", browser: "The browser's" };

/** Which player plays the sound, for who wants to compare them. */
function Player() {
  const { preferences } = useState();
  const { setPlayer } = useActions();
  return (
    <>
      <dt id="player">Play sound by</dt>
      <dd>
        <select
          aria-labelledby="player"
          value={preferences.value.player ?? ""}
          onChange={(event) =>
            setPlayer((event.currentTarget.value || null) as Preferences["player"])
          }
        >
          {PLAYERS.map((one) => (
            <option key={one} value={one ?? ""}>
              {one ? PLAYER_NAMES[one] : "Automatic"}
            </option>
          ))}
        </select>
      </dd>
    </>
  );
}

function Fact({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

function Reasons({ sentences }: { sentences: string[] }) {
  if (sentences.length === 0) return null;
  return (
    <>
      <dt>Why</dt>
      {sentences.map((sentence) => (
        <dd key={sentence} class="reason">
          {sentence}
        </dd>
      ))}
    </>
  );
}
