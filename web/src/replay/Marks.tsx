import { t } from "../words/words";
import { clockWords } from "./replayWords";
import type { Mark } from "./timeline";

interface MarksProps {
  marks: readonly Mark[];
  onSeek: (ms: number) => void;
}

/** All events of the part; choosing one seeks to it. */
export function Marks({ marks, onSeek }: MarksProps) {
  if (marks.length === 0) return <p class="quiet">{t("replay.events.none")}</p>;
  return (
    <ol class="replay-marks" aria-label={t("replay.events")}>
      {marks.map((mark) => (
        <li key={`${mark.atMs} ${mark.words}`} class={`is-${mark.kind}`}>
          <button type="button" onClick={() => onSeek(mark.atMs)}>
            <span class="figure">{clockWords(mark.atMs)}</span> {mark.words}
          </button>
        </li>
      ))}
    </ol>
  );
}
