import type { Signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { t } from "../words/words";
import type { Player, View } from "./player";
import { clockWords } from "./replayWords";
import type { Timeline } from "./timeline";

interface TimeProps {
  timeline: Timeline;
  /** Changes with each frame, so only small components read it. */
  momentMs: Signal<number>;
  onSeek: (ms: number) => void;
}

interface ControlsProps extends TimeProps {
  player: Player;
  isPlaying: Signal<boolean>;
  view: Signal<View>;
}

const RATES = [
  [1, "replay.speed.normal"],
  [0.5, "replay.speed.half"],
  [0.25, "replay.speed.quarter"],
] as const;
const STEP_MS = 1000;

/** Play, scrub, step from event to event, and choose the view. */
export function Controls({ player, timeline, momentMs, isPlaying, view, onSeek }: ControlsProps) {
  const toggle = () => {
    if (isPlaying.peek()) player.pause();
    else void player.play().catch(() => {});
  };

  useEffect(() => {
    const keys: Record<string, () => void> = {
      " ": toggle,
      n: () => onSeek(timeline.next(momentMs.peek())?.atMs ?? momentMs.peek()),
      p: () => onSeek(timeline.previous(momentMs.peek())?.atMs ?? momentMs.peek()),
      ArrowLeft: () => onSeek(momentMs.peek() - STEP_MS),
      ArrowRight: () => onSeek(momentMs.peek() + STEP_MS),
    };
    const press = (event: KeyboardEvent) => {
      const isElsewhere =
        event.target instanceof Element && event.target.closest("input, select, button");
      const act = event.ctrlKey || event.altKey || event.metaKey ? undefined : keys[event.key];
      if (!act || isElsewhere) return;
      event.preventDefault();
      act();
    };
    window.addEventListener("keydown", press);
    return () => window.removeEventListener("keydown", press);
  }, [player, timeline, onSeek]);

  const time = { timeline, momentMs, onSeek };
  return (
    <section class="replay-controls" aria-label={t("replay.controls")}>
      <Scrubber {...time} />
      <div class="replay-row">
        <button type="button" class="main-button" onClick={toggle}>
          {t(isPlaying.value ? "replay.pause" : "replay.play")}
        </button>
        <Clock {...time} />
        <Steps {...time} />
        <label class="field">
          <span>{t("replay.speed")}</span>
          <select
            onChange={(event) => {
              player.rate = Number(event.currentTarget.value);
            }}
          >
            {RATES.map(([rate, name]) => (
              <option key={rate} value={rate} selected={rate === player.rate}>
                {t(name)}
              </option>
            ))}
          </select>
        </label>
        <label class="field">
          <span>{t("replay.view")}</span>
          <select
            value={view.value}
            onChange={(event) => {
              const moment = momentMs.peek();
              view.value = player.view = event.currentTarget.value as View;
              onSeek(moment);
            }}
          >
            <option value="was">{t("replay.view.was")}</option>
            <option value="seen">{t("replay.view.seen")}</option>
          </select>
        </label>
      </div>
    </section>
  );
}

function Scrubber({ timeline, momentMs, onSeek }: TimeProps) {
  return (
    <input
      type="range"
      aria-label={t("replay.time")}
      aria-valuetext={clockWords(momentMs.value)}
      min={0}
      max={Math.ceil(timeline.lengthMs)}
      value={momentMs.value}
      onInput={(event) => onSeek(event.currentTarget.valueAsNumber)}
    />
  );
}

function Clock({ timeline, momentMs }: TimeProps) {
  return (
    <span class="replay-clock figure">
      {t("replay.clock", {
        at: clockWords(momentMs.value),
        length: clockWords(timeline.lengthMs),
      })}
    </span>
  );
}

function Steps({ timeline, momentMs, onSeek }: TimeProps) {
  const previous = timeline.previous(momentMs.value);
  const next = timeline.next(momentMs.value);
  return (
    <>
      <button
        type="button"
        disabled={!previous}
        title={t("replay.key", { key: "P" })}
        onClick={() => previous && onSeek(previous.atMs)}
      >
        {t("replay.previous")}
      </button>
      <button
        type="button"
        disabled={!next}
        title={t("replay.key", { key: "N" })}
        onClick={() => next && onSeek(next.atMs)}
      >
        {t("replay.next")}
      </button>
    </>
  );
}
