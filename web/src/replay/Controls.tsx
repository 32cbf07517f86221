import type { Signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Player, View } from "./player";
import type { Open } from "./Replay";
import type { Mark } from "./timeline";
import { clockWords } from "./words";

interface ControlsProps {
  player: Player;
  open: Open;
  momentMs: Signal<number>;
  isPlaying: Signal<boolean>;
  view: Signal<View>;
}

const RATES = [1, 0.5, 0.25] as const;
const STEP_MS = 1000;

/** Play, scrub, step from event to event, and choose whose moment is shown. */
export function Controls({ player, open, momentMs, isPlaying, view }: ControlsProps) {
  const { timeline } = open;
  const seek = (ms: number) => {
    player.seek(Math.min(Math.max(0, ms), timeline.lengthMs), timeline);
    momentMs.value = player.momentMs(timeline);
  };
  const jump = (mark: Mark | null) => {
    if (mark) seek(mark.atMs);
  };
  const toggle = () => {
    if (isPlaying.peek()) player.pause();
    else void player.play().catch(() => {});
  };
  const next = () => jump(timeline.next(momentMs.peek()));
  const previous = () => jump(timeline.previous(momentMs.peek()));

  useEffect(() => {
    const keys: Record<string, () => void> = {
      " ": toggle,
      n: next,
      p: previous,
      ArrowLeft: () => seek(momentMs.peek() - STEP_MS),
      ArrowRight: () => seek(momentMs.peek() + STEP_MS),
    };
    const press = (event: KeyboardEvent) => {
      const isElsewhere = event.target instanceof Element && event.target.closest("input, select");
      const act = event.ctrlKey || event.altKey || event.metaKey ? undefined : keys[event.key];
      if (!act || isElsewhere) return;
      event.preventDefault();
      act();
    };
    window.addEventListener("keydown", press);
    return () => window.removeEventListener("keydown", press);
  }, [player, timeline]);

  return (
    <section class="replay-controls" aria-label="Playback">
      <input
        type="range"
        aria-label="Time"
        aria-valuetext={clockWords(momentMs.value)}
        min={0}
        max={Math.ceil(timeline.lengthMs)}
        value={momentMs.value}
        onInput={(event) => seek(event.currentTarget.valueAsNumber)}
      />
      <div class="replay-row">
        <button type="button" class="main-button" onClick={toggle}>
          {isPlaying.value ? "Pause" : "Play"}
        </button>
        <span class="figure">
          {clockWords(momentMs.value)} of {clockWords(timeline.lengthMs)}
        </span>
        <button
          type="button"
          disabled={!timeline.previous(momentMs.value)}
          title="Key P"
          onClick={previous}
        >
          Previous event
        </button>
        <button
          type="button"
          disabled={!timeline.next(momentMs.value)}
          title="Key N"
          onClick={next}
        >
          Next event
        </button>
        <label class="field">
          <span>Speed</span>
          <select
            onChange={(event) => {
              player.rate = Number(event.currentTarget.value);
            }}
          >
            {RATES.map((rate) => (
              <option key={rate} value={rate} selected={rate === player.rate}>
                {rate === 1 ? "normal" : rate === 0.5 ? "half" : "a quarter"}
              </option>
            ))}
          </select>
        </label>
        <label class="field">
          <span>Show it</span>
          <select
            value={view.value}
            onChange={(event) => {
              const moment = momentMs.peek();
              view.value = player.view = event.currentTarget.value as View;
              seek(moment);
            }}
          >
            <option value="was">as it was</option>
            <option value="seen">as the operator saw it</option>
          </select>
        </label>
      </div>
      <Marks marks={timeline.marks} onChoose={jump} />
    </section>
  );
}

/** All events of the part; choosing one goes there. */
function Marks({ marks, onChoose }: { marks: readonly Mark[]; onChoose: (mark: Mark) => void }) {
  return (
    <ol class="replay-marks" aria-label="Events">
      {marks.map((mark) => (
        <li key={`${mark.atMs} ${mark.words}`} class={`is-${mark.kind}`}>
          <button type="button" onClick={() => onChoose(mark)}>
            <span class="figure">{clockWords(mark.atMs)}</span> {mark.words}
          </button>
        </li>
      ))}
    </ol>
  );
}
