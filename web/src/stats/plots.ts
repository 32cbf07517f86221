/** What is plotted. Pure. */

import type { Code } from "../words/words";
import type { Field, History } from "./history";

export interface Line {
  name: Code;
  field: Field;
  /** The value is divided by this, as to show bit/s as kbit/s. */
  per?: number;
}

export interface Plot {
  title: Code;
  unit: Code;
  lines: readonly Line[];
  /** Whether values can be negative. */
  isSigned?: boolean;
}

export const PLOTS: readonly Plot[] = [
  {
    title: "stats.plot.ages",
    unit: "stats.unit.ms",
    lines: [
      { name: "stats.line.picture", field: "pictureMs" },
      { name: "stats.line.sound", field: "soundMs" },
    ],
  },
  {
    title: "stats.plot.skew",
    unit: "stats.unit.ms",
    lines: [{ name: "stats.line.skew", field: "skewMs" }],
    isSigned: true,
  },
  {
    title: "stats.plot.jitter",
    unit: "stats.unit.ms",
    lines: [
      { name: "stats.line.jitter", field: "jitterMs" },
      { name: "stats.line.buffer", field: "bufferMs" },
      { name: "stats.line.queue", field: "queueMs" },
    ],
  },
  {
    title: "stats.plot.rate",
    unit: "stats.unit.kbps",
    lines: [
      { name: "stats.line.link", field: "linkBps", per: 1000 },
      { name: "stats.line.used", field: "usedBps", per: 1000 },
    ],
  },
  {
    title: "stats.plot.size",
    unit: "stats.unit.px",
    lines: [
      { name: "stats.line.width", field: "widthPx" },
      { name: "stats.line.asked", field: "askedPx" },
    ],
  },
  {
    title: "stats.plot.pictures",
    unit: "stats.unit.hz",
    lines: [
      { name: "stats.line.sent", field: "sentHz" },
      { name: "stats.line.arrived", field: "arrivedHz" },
      { name: "stats.line.shown", field: "shownHz" },
    ],
  },
  {
    title: "stats.plot.command",
    unit: "stats.unit.ms",
    lines: [{ name: "stats.line.command", field: "roundTripMs" }],
  },
];

/** The values of one line, oldest first. */
export function valuesOf(history: History, { field, per = 1 }: Line): (number | null)[] {
  return history.column(field).map((value) => value && value / per);
}

/** When each sample was taken, in seconds before now: all below zero. */
export function secondsOf(history: History, nowMs: number): number[] {
  return history.times().map((atMs) => (atMs - nowMs) / 1000);
}

const LEAST_SPAN_S = 60;

/** The span of the time axis: the whole past, at least a minute. */
export function spanOf(seconds: readonly number[]): [number, number] {
  return [Math.min(-LEAST_SPAN_S, seconds[0] ?? 0), 0];
}

/** A scale from zero to a little above the maximum, so that a small change does not look large. */
export function scaleOf(least: number, most: number, isSigned: boolean): [number, number] {
  const top = Math.max(10, most * 1.1);
  return [isSigned ? Math.min(-10, least * 1.1) : 0, top];
}

/** `-90` as `1:30`. */
export function clockWords(seconds: number): string {
  const whole = Math.round(Math.abs(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
