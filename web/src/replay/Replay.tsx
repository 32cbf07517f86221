import { type Signal, useSignal, useSignalEffect } from "@preact/signals";
import { useCallback, useEffect, useMemo, useRef } from "preact/hooks";
import type { TapeListing } from "../messages";
import { t } from "../words/words";
import { Controls } from "./Controls";
import { loadListing, loadPart } from "./load";
import { Marks } from "./Marks";
import { Moment } from "./Moment";
import { Plots } from "./Plots";
import { Player, type View } from "./player";
import { partWords } from "./replayWords";
import { type OpenPart, Timeline } from "./timeline";
import { Views } from "./Views";

/** The page of `wax replay`: the parts, picture and sound, and the state at each moment. */
export function Replay() {
  const listing = useSignal<TapeListing | null>(null);
  const name = useSignal<string | null>(null);
  const open = useSignal<OpenPart | null>(null);
  const problem = useSignal<string | null>(null);

  useEffect(() => {
    loadListing()
      .then((found) => {
        listing.value = found;
        name.value = found.parts.at(-1)?.name ?? null;
      })
      .catch((error: Error) => {
        problem.value = error.message;
      });
  }, [listing, name, problem]);

  useSignalEffect(() => {
    const wanted = name.value;
    if (wanted === null) return;
    problem.value = null;
    loadPart(wanted)
      .then((content) => {
        if (name.peek() === wanted) open.value = { content, timeline: new Timeline(content) };
      })
      .catch((error: Error) => {
        if (name.peek() !== wanted) return;
        open.value = null;
        problem.value = error.message;
      });
  });

  const words = useMemo(() => partWords(), []);
  const parts = listing.value?.parts ?? [];
  const at = parts.findIndex((one) => one.name === name.value);
  const follow = () => {
    const next = parts[at + 1];
    if (next) name.value = next.name;
    return next !== undefined;
  };
  return (
    <main class="replay">
      <header class="replay-head">
        <h1>{t("replay.title")}</h1>
        {parts.length > 1 && (
          <label class="field">
            <span>{t("replay.part")}</span>
            <select
              value={name.value ?? ""}
              onChange={(event) => {
                name.value = event.currentTarget.value;
              }}
            >
              {parts.map((one) => (
                <option key={one.name} value={one.name}>
                  {words(one)}
                </option>
              ))}
            </select>
          </label>
        )}
      </header>
      {(problem.value ?? open.value?.content.problem) && (
        <p class="replay-problem" role="alert">
          {problem.value ?? open.value?.content.problem}
        </p>
      )}
      {open.value && <Part open={open.value} onEnded={follow} />}
    </main>
  );
}

/** Plays one part; `onEnded` says whether another follows. */
function Part({ open, onEnded }: { open: OpenPart; onEnded: () => boolean }) {
  const picture = useRef<HTMLVideoElement>(null);
  const sound = useRef<HTMLAudioElement>(null);
  const player = useSignal<Player | null>(null);
  const momentMs = useSignal(0);
  const isPlaying = useSignal(false);
  const view = useSignal<View>("was");
  const goesOn = useRef(false);

  useEffect(() => {
    if (picture.current && sound.current) {
      player.value = new Player(picture.current, sound.current);
    }
  }, [player]);

  useEffect(() => {
    const one = player.value;
    if (!one) return;
    one.view = view.peek();
    one.load(open.content);
    momentMs.value = 0;
    if (goesOn.current) void one.play().catch(() => {});
    goesOn.current = false;
    let frame = 0;
    const tick = () => {
      one.follow(open.timeline);
      momentMs.value = Math.min(open.timeline.lengthMs, one.momentMs(open.timeline));
      isPlaying.value = one.isPlaying && !one.hasEnded;
      if (one.hasEnded && one.mediaMs > 0 && !goesOn.current) {
        goesOn.current = onEnded();
        if (!goesOn.current) one.pause();
      }
      frame = requestAnimationFrame(tick);
    };
    tick();
    return () => {
      cancelAnimationFrame(frame);
      one.pause();
    };
  }, [open, player.value, isPlaying, momentMs, view]);

  const { content, timeline } = open;
  const seek = useCallback(
    (ms: number) => {
      const one = player.peek();
      one?.seek(Math.min(Math.max(0, ms), timeline.lengthMs), timeline);
      if (one) momentMs.value = one.momentMs(timeline);
    },
    [timeline, player, momentMs],
  );
  return (
    <div class="replay-part">
      <div class="replay-picture">
        <Views content={content} player={player.value} momentMs={momentMs} picture={picture} />
        {/* biome-ignore lint/a11y/useMediaCaption: there are none of what a robot hears */}
        <audio ref={sound} preload="auto" />
        <StopMark open={open} momentMs={momentMs} />
      </div>
      {player.value && (
        <Controls
          player={player.value}
          timeline={timeline}
          momentMs={momentMs}
          isPlaying={isPlaying}
          view={view}
          onSeek={seek}
        />
      )}
      <div class="replay-side">
        <Moment open={open} momentMs={momentMs} view={view} />
        {player.value && <Marks marks={timeline.marks} onSeek={seek} />}
      </div>
      <Plots open={open} momentMs={momentMs} />
    </div>
  );
}

function StopMark({ open, momentMs }: { open: OpenPart; momentMs: Signal<number> }) {
  const stop = open.timeline.stopAt(momentMs.value);
  if (!stop) return null;
  const who = stop.by_host ? t("replay.who.host") : open.timeline.who(stop.viewer);
  return <p class="replay-stop">{t("replay.stop.in_force", { who })}</p>;
}
