import { useEffect, useId, useMemo, useRef } from "preact/hooks";
import UPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { t } from "../words/words";
import type { History, Mark } from "./history";
import { clockWords, type Plot as PlotOf, scaleOf, secondsOf, spanOf, valuesOf } from "./plots";
import { type Summary, summary } from "./summary";

const HEIGHT_PX = 120;
/** Lines differ by dashes, too, not only by colour. */
const DASHES = [[], [6, 3], [2, 3]];
/** Marks that change what the user can do; the others are frequent decisions of the server. */
const STRONG: ReadonlySet<Mark["kind"]> = new Set(["link", "turn", "stop", "robot"]);
const SMALL_MARK_PX = 6;
const LOOKS = ["(prefers-color-scheme: dark)", "(forced-colors: active)"];

interface Props {
  plot: PlotOf;
  history: History;
  nowMs: number;
}

/** One plot; its table has the same data in figures, and is its legend. */
export function Plot({ plot, history, nowMs }: Props) {
  const title = useId();
  const columns = useMemo(
    () => plot.lines.map((line) => valuesOf(history, line)),
    // `history` is mutated in place; `nowMs` tells when.
    [plot, history, nowMs],
  );
  const table = useRef<HTMLTableElement>(null);
  return (
    <figure class="stats-plot" aria-labelledby={title}>
      <figcaption id={title}>
        {t(plot.title)}, {t(plot.unit)}
      </figcaption>
      <Canvas plot={plot} history={history} nowMs={nowMs} columns={columns} table={table} />
      <table ref={table} aria-labelledby={title}>
        <thead>
          <tr>
            <td />
            {HEADS.map((head) => (
              <th key={head} scope="col">
                {t(head)}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {plot.lines.map((line, i) => (
            <tr key={line.name}>
              <th scope="row" class={`stats-line is-line-${i}`}>
                {t(line.name)}
              </th>
              {inFigures(summary(columns[i] ?? [])).map((figure, at) => (
                <td key={HEADS[at]}>{figure}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </figure>
  );
}

const HEADS = [
  "stats.table.least",
  "stats.table.median",
  "stats.table.most",
  "stats.table.now",
] as const;

function inFigures(line: Summary | null): string[] {
  if (!line) return HEADS.map(() => "–");
  return [line.least, line.median, line.most, line.newest].map((value) => `${Math.round(value)}`);
}

interface CanvasProps extends Props {
  columns: (number | null)[][];
  table: { current: HTMLTableElement | null };
}

/** Draws the plot, with colours read from the table, so that they follow every theme. */
function Canvas({ plot, history, nowMs, columns, table }: CanvasProps) {
  const box = useRef<HTMLDivElement>(null);
  const chart = useRef<UPlot | null>(null);
  const newest = useRef({ nowMs, columns });
  newest.current = { nowMs, columns };

  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const data = (): UPlot.AlignedData => [
      secondsOf(history, newest.current.nowMs),
      ...newest.current.columns,
    ];
    const draw = () => {
      chart.current?.destroy();
      const colors = colorsOf(table.current, plot.lines.length);
      const marks = (u: UPlot) => drawMarks(u, history.marks, newest.current.nowMs, colors.ink);
      const options = optionsOf(plot, element.clientWidth, colors, marks);
      chart.current = new UPlot(options, data(), element);
    };
    draw();
    const leaving = new AbortController();
    const { signal } = leaving;
    for (const look of LOOKS) matchMedia(look).addEventListener("change", draw, { signal });
    const resized = new ResizeObserver(() => {
      chart.current?.setSize({ width: element.clientWidth, height: HEIGHT_PX });
    });
    resized.observe(element);
    return () => {
      leaving.abort();
      resized.disconnect();
      chart.current?.destroy();
      chart.current = null;
    };
  }, [plot, history, table]);

  useEffect(() => {
    chart.current?.setData([secondsOf(history, nowMs), ...columns]);
  }, [history, nowMs, columns]);

  return <div ref={box} class="stats-canvas" aria-hidden="true" />;
}

interface Colors {
  ink: string;
  lines: string[];
}

function colorsOf(table: HTMLElement | null, count: number): Colors {
  const of = (element: Element | null | undefined) =>
    element ? getComputedStyle(element).color : "";
  return {
    ink: of(table),
    lines: Array.from({ length: count }, (_, i) => of(table?.querySelector(`.is-line-${i}`))),
  };
}

function optionsOf(
  plot: PlotOf,
  width: number,
  { ink, lines }: Colors,
  draw: (u: UPlot) => void,
): UPlot.Options {
  const axis = { stroke: ink, grid: { show: false }, ticks: { stroke: ink, size: 4, width: 1 } };
  return {
    width,
    height: HEIGHT_PX,
    cursor: { show: false },
    legend: { show: false },
    select: { show: false, left: 0, top: 0, width: 0, height: 0 },
    scales: {
      x: { time: false, range: (u) => spanOf((u.data[0] ?? []) as number[]) },
      y: { range: (_u, least, most) => scaleOf(least ?? 0, most ?? 0, plot.isSigned === true) },
    },
    axes: [
      { ...axis, size: 24, values: (_u, splits) => splits.map(clockWords) },
      { ...axis, size: 52, space: 24 },
    ],
    series: [
      {},
      ...plot.lines.map((_line, i) => ({
        stroke: lines[i] ?? ink,
        width: 2,
        dash: DASHES[i] ?? [],
        points: { show: false },
      })),
    ],
    hooks: { draw: [draw] },
  };
}

function drawMarks(u: UPlot, marks: readonly Mark[], nowMs: number, ink: string): void {
  const { ctx, bbox } = u;
  const pxPerCssPx = devicePixelRatio || 1;
  ctx.save();
  ctx.strokeStyle = ink;
  ctx.lineWidth = pxPerCssPx;
  for (const { atMs, kind } of marks) {
    const x = u.valToPos((atMs - nowMs) / 1000, "x", true);
    if (x < bbox.left) continue;
    const bottom = bbox.top + bbox.height;
    ctx.beginPath();
    ctx.moveTo(x, STRONG.has(kind) ? bbox.top : bottom - SMALL_MARK_PX * pxPerCssPx);
    ctx.lineTo(x, bottom);
    ctx.stroke();
  }
  ctx.restore();
}
