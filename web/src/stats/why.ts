/**
 * Why it is slow, in one sentence. Pure.
 *
 * The first rule that applies gives the answer: its cause would make the figures of later rules
 * meaningless. Each uses medians over the last seconds, so that a single bad moment does not count.
 */

import type { Code, Values } from "../words/words";
import type { Field, History } from "./history";
import { median } from "./summary";

/** What the figures alone do not show. */
export interface Now {
  nowMs: number;
  isConnected: boolean;
  isHidden: boolean;
  isBlanked: boolean;
  wantsPicture: boolean;
  /** Why the robot does not move, or moves more slowly than commanded. */
  driveReason: string | null;
}

export interface Why {
  code: Code & `stats.why.${string}`;
  values: Values;
}

interface Seen extends Now {
  /** The median of the last seconds; null if it is unknown. */
  of: (field: Field) => number | null;
  isMeasured: boolean;
}

type Rule = (seen: Seen) => Why | null;

const WINDOW_MS = 10_000;
/** Without a new sample for this long, nothing arrives. */
const QUIET_MS = 5000;
const QUEUE_MS = 100;
/** A share of the pictures below this is few. */
const FEW = 0.7;
/** A picture younger than this is not slow. */
const OLD_MS = 150;
/** A part of the delay counts as its reason from this share on. */
const MOST_OF_IT = 0.5;
const UNEVEN_MS = 15;
const LOW_HZ = 12;

const RULES: readonly Rule[] = [
  unconnected,
  unmeasured,
  blanked,
  hidden,
  robot,
  pictureless,
  queue,
  small,
  starved,
  browser,
  lossy,
  slowCamera,
  distance,
  uneven,
  held,
];

export function why(history: History, now: Now): Why {
  const sinceMs = now.nowMs - WINDOW_MS;
  const newestMs = history.newestMs;
  const seen = {
    ...now,
    of: (field: Field) => median(history.since(field, sinceMs)),
    isMeasured: newestMs !== null && now.nowMs - newestMs < QUIET_MS,
  };
  for (const rule of RULES) {
    const found = rule(seen);
    if (found) return found;
  }
  return { code: "stats.why.nothing", values: {} };
}

function unconnected({ isConnected }: Seen): Why | null {
  return isConnected ? null : { code: "stats.why.unconnected", values: {} };
}

function unmeasured({ isMeasured }: Seen): Why | null {
  return isMeasured ? null : { code: "stats.why.unmeasured", values: {} };
}

function blanked({ isBlanked }: Seen): Why | null {
  return isBlanked ? { code: "stats.why.blanked", values: {} } : null;
}

/** A hidden page presents nothing, whatever the link carries. */
function hidden({ isHidden }: Seen): Why | null {
  return isHidden ? { code: "stats.why.hidden", values: {} } : null;
}

function robot({ driveReason }: Seen): Why | null {
  return driveReason === null ? null : { code: "stats.why.robot", values: { reason: driveReason } };
}

/** The link is too thin for any picture. */
function pictureless({ of, wantsPicture }: Seen): Why | null {
  const linkBps = of("linkBps");
  if (!wantsPicture || of("widthPx") !== 0 || linkBps === null) return null;
  return { code: "stats.why.pictureless", values: { kbps: kilo(linkBps) } };
}

/** Other traffic fills the link, and our packets wait behind it. */
function queue({ of }: Seen): Why | null {
  const queueMs = of("queueMs") ?? 0;
  return queueMs < QUEUE_MS
    ? null
    : { code: "stats.why.queue", values: { ms: Math.round(queueMs) } };
}

function small({ of, wantsPicture }: Seen): Why | null {
  const [widthPx, askedPx, linkBps] = [of("widthPx"), of("askedPx"), of("linkBps")];
  if (!wantsPicture || widthPx === null || askedPx === null || linkBps === null) return null;
  if (widthPx >= askedPx) return null;
  return { code: "stats.why.small", values: { kbps: kilo(linkBps), px: widthPx } };
}

/** The link carries only every other picture, by temporal layers. */
function starved({ of }: Seen): Why | null {
  const [sentHz, linkBps, usedBps] = [of("sentHz"), of("linkBps"), of("usedBps")];
  if (sentHz === null || sentHz === 0 || linkBps === null || usedBps === null) return null;
  const isFull = usedBps > FEW * linkBps;
  if (sentHz >= LOW_HZ || !isFull) return null;
  return { code: "stats.why.starved", values: { kbps: kilo(linkBps), hz: Math.round(sentHz) } };
}

/** Pictures arrive, but the browser does not show them. */
function browser({ of }: Seen): Why | null {
  const [arrivedHz, shownHz] = [of("arrivedHz"), of("shownHz")];
  if (arrivedHz === null || shownHz === null || shownHz >= FEW * arrivedHz) return null;
  const values = { shown: Math.round(shownHz), sent: Math.round(arrivedHz) };
  return { code: "stats.why.browser", values };
}

/** Pictures are sent, but do not arrive. */
function lossy({ of }: Seen): Why | null {
  const [sentHz, arrivedHz] = [of("sentHz"), of("arrivedHz")];
  if (sentHz === null || arrivedHz === null || arrivedHz >= FEW * sentHz) return null;
  const values = { arrived: Math.round(arrivedHz), sent: Math.round(sentHz) };
  return { code: "stats.why.lossy", values };
}

function slowCamera({ of, wantsPicture }: Seen): Why | null {
  const sentHz = of("sentHz");
  if (!wantsPicture || !sentHz || sentHz >= LOW_HZ) return null;
  return { code: "stats.why.slow_camera", values: { hz: Math.round(sentHz) } };
}

/** Half the round trip is the least that anything takes. */
function distance({ of }: Seen): Why | null {
  const [ageMs, roundTripMs] = [ageOf(of), of("roundTripMs")];
  if (ageMs === null || roundTripMs === null || ageMs < OLD_MS) return null;
  const ownMs = roundTripMs / 2;
  if (ownMs < MOST_OF_IT * ageMs) return null;
  const values = { own: Math.round(ownMs), all: Math.round(ageMs) };
  return { code: "stats.why.distance", values };
}

function uneven({ of }: Seen): Why | null {
  const [jitterMs, bufferMs, soundMs] = [of("jitterMs"), of("bufferMs"), of("soundMs")];
  if (jitterMs === null || bufferMs === null || soundMs === null) return null;
  if (soundMs < OLD_MS || jitterMs < UNEVEN_MS || bufferMs < MOST_OF_IT * soundMs) return null;
  const values = { jitter: Math.round(jitterMs), ms: Math.round(bufferMs) };
  return { code: "stats.why.uneven", values };
}

/** The picture could be shown sooner, but waits for the sound. */
function held({ of }: Seen): Why | null {
  const [pictureMs, heldMs] = [of("pictureMs"), of("heldMs")];
  if (pictureMs === null || heldMs === null || pictureMs < OLD_MS) return null;
  if (heldMs < MOST_OF_IT * pictureMs) return null;
  return { code: "stats.why.held", values: { ms: Math.round(heldMs) } };
}

function ageOf(of: Seen["of"]): number | null {
  return of("pictureMs") ?? of("soundMs");
}

function kilo(bps: number): number {
  return Math.round(bps / 1000);
}
