import type { ComponentChildren } from "preact";
import { useState } from "./context";
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

/** How late everything is, and for whoever opens it: how well it plays, what is sent, and why. */
export function Facts() {
  const { facts, served, playout, isConnected, isSilent, room } = useState();
  const { pictureMs, pictureErrorMs, soundMs, roundTripMs, fps, pauses, freezes } = facts.value;
  const battery = room.value && batteryWords(room.value.robot);
  return (
    <details class={isConnected.value ? "facts" : "facts is-unknown"}>
      <summary>
        Delay <span class="figure">{msWords(isSilent.value ? null : (pictureMs ?? soundMs))}</span>
      </summary>
      <dl>
        <Fact name="Picture age">{ageWords(pictureMs, pictureErrorMs)}</Fact>
        <Fact name="Sound age">{msWords(soundMs)}</Fact>
        <Fact name="Skew">{skewWords(soundMs, pictureMs)}</Fact>
        <Fact name="Round trip">{msWords(roundTripMs)}</Fact>
        <Fact name="Pictures">{fps === null ? "–" : `${fps} a second`}</Fact>
        <Fact name="Pauses in a minute">{breakWords(pauses)}</Fact>
        <Fact name="Freezes in a minute">{breakWords(freezes)}</Fact>
        <Fact name="Policy">{playout.value?.policy ?? "–"}</Fact>
        <Fact name="Sent picture">{sentPictureWords(served.value)}</Fact>
        <Fact name="Sent sound">{sentSoundWords(served.value)}</Fact>
        <Fact name="Link">{linkWords(served.value)}</Fact>
        {battery && <Fact name="Battery">{battery}</Fact>}
        <Reasons sentences={reasons(playout.value, served.value)} />
      </dl>
    </details>
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
