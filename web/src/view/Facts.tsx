import { useState } from "./context";
import { msWords, skewWords } from "./words";

/** How late everything is, for whoever wants to know. */
export function Facts() {
  const { facts, isConnected } = useState();
  const { pictureMs, soundMs, roundTripMs, fps } = facts.value;
  return (
    <details class={isConnected.value ? "facts" : "facts is-unknown"}>
      <summary>
        Delay <span class="figure">{msWords(pictureMs ?? soundMs)}</span>
      </summary>
      <dl>
        <dt>Picture age</dt>
        <dd>{msWords(pictureMs)}</dd>
        <dt>Sound age</dt>
        <dd>{msWords(soundMs)}</dd>
        <dt>Skew</dt>
        <dd>{skewWords(soundMs, pictureMs)}</dd>
        <dt>Round trip</dt>
        <dd>{msWords(roundTripMs)}</dd>
        <dt>Pictures</dt>
        <dd>{fps === null ? "–" : `${fps} a second`}</dd>
      </dl>
    </details>
  );
}
