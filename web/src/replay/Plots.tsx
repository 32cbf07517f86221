import type { Signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Steered } from "../messages";
import { t } from "../words/words";
import { type Box, type Point, scaleFor, steps, xOf } from "./plot";
import type { Mark, OpenPart, Timeline } from "./timeline";

const WIDTH = 1000;
const HEIGHT = 100;

interface Line {
  name: string;
  kind: string;
  points: Point[];
}

interface PlotProps {
  title: string;
  unit: string;
  lines: Line[];
  least: number;
  isSigned?: boolean;
  lengthMs: number;
  marks: readonly Mark[];
}

/** Delays, and what was commanded and done, over the whole part. */
export function Plots({ open, momentMs }: { open: OpenPart; momentMs: Signal<number> }) {
  const { timeline } = open;
  const plots = useMemo(() => plotsOf(timeline), [timeline]);
  return (
    <section class="replay-plots" aria-label={t("replay.plots")}>
      {plots.map((plot) => (
        <Plot key={plot.title} {...plot} momentMs={momentMs} />
      ))}
    </section>
  );
}

function Plot({
  title,
  unit,
  lines,
  least,
  isSigned = false,
  lengthMs,
  marks,
  momentMs,
}: PlotProps & { momentMs: Signal<number> }) {
  const most = scaleFor(
    lines.flatMap((line) => line.points.map((point) => point.value)),
    least,
  );
  const box = {
    fromMs: 0,
    toMs: lengthMs,
    least: isSigned ? -most : 0,
    most,
    width: WIDTH,
    height: HEIGHT,
  };
  return (
    <figure class="replay-plot">
      <figcaption>
        {t("replay.plot.to", { title, most, unit })}
        {lines.map((line) => (
          <span key={line.name} class={`is-${line.kind}`}>
            {line.name}
          </span>
        ))}
      </figcaption>
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={title}
      >
        {marks.map((mark) => (
          <path
            key={`${mark.atMs} ${mark.words}`}
            class={`mark is-${mark.kind}`}
            d={`M${xOf(mark.atMs, box)} 0V${HEIGHT}`}
          />
        ))}
        {lines.map((line) => (
          <path key={line.name} class={`line is-${line.kind}`} d={steps(line.points, box)} />
        ))}
        <Now momentMs={momentMs} box={box} />
      </svg>
    </figure>
  );
}

/** The time cursor; a component of its own, so that each frame redraws nothing else. */
function Now({ momentMs, box }: { momentMs: Signal<number>; box: Box }) {
  return <path class="now" d={`M${xOf(momentMs.value, box)} 0V${HEIGHT}`} />;
}

function plotsOf(timeline: Timeline): PlotProps[] {
  const { lengthMs, marks } = timeline;
  const own = timeline.watched.filter((one) => one.event.drives);
  const delay = (of: "picture_ms" | "sound_ms" | "round_trip_ms") =>
    own.map(({ atMs, event }) => ({ atMs, value: event[of] }));
  const { steered } = timeline;
  const speeds = (title: string, wanted: (of: Steered) => number, given: typeof wanted) => ({
    title,
    unit: t("replay.plot.mps"),
    least: 0.1,
    isSigned: true,
    lengthMs,
    marks,
    lines: [
      {
        name: t("replay.line.wanted"),
        kind: "picture",
        points: steered.map(({ atMs, event }) => ({ atMs, value: wanted(event) })),
      },
      {
        name: t("replay.line.given"),
        kind: "sound",
        points: steered.map(({ atMs, event }) => ({ atMs, value: given(event) })),
      },
    ],
  });
  const wasSideways = steered.some((one) => one.event.wanted_lateral_mps || one.event.lateral_mps);
  return [
    {
      title: t("replay.plot.delay"),
      unit: t("stats.unit.ms"),
      least: 100,
      lengthMs,
      marks,
      lines: [
        { name: t("replay.line.picture"), kind: "picture", points: delay("picture_ms") },
        { name: t("replay.line.sound"), kind: "sound", points: delay("sound_ms") },
        { name: t("replay.line.link"), kind: "link", points: delay("round_trip_ms") },
      ],
    },
    {
      title: t("replay.plot.age"),
      unit: t("stats.unit.ms"),
      least: 50,
      lengthMs,
      marks,
      lines: [
        {
          name: t("replay.line.age"),
          kind: "link",
          points: timeline.counted.map(({ atMs, event }) => ({ atMs, value: event.age_ms })),
        },
      ],
    },
    speeds(
      t("replay.plot.forward"),
      (one) => one.wanted_linear_mps,
      (one) => one.linear_mps,
    ),
    ...(wasSideways
      ? [
          speeds(
            t("replay.plot.sideways"),
            (one) => one.wanted_lateral_mps ?? 0,
            (one) => one.lateral_mps ?? 0,
          ),
        ]
      : []),
  ];
}
