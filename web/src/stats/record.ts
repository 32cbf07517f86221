/** Records the history from the moment the page opens, so that there is a past to show later. */

import { effect } from "@preact/signals";
import type { LinkState } from "../link/link";
import type { SoundPlayerState } from "../sound/soundPlayback";
import type { Facts, State } from "../state";
import { policyWords, sizeWords } from "../view/figures";
import { said } from "../words/said";
import { type Code, t } from "../words/words";
import { History, type Mark, type Sample } from "./history";

/** Starts to record what the page measures and receives; costs a few numbers a second. */
export function recordHistory(
  state: State,
  nowMs: () => number = () => performance.now(),
): History {
  const history = new History();
  const mark = (kind: Mark["kind"], text: string) => history.mark({ atMs: nowMs(), kind, text });
  const before = state.facts.peek();
  state.facts.subscribe((facts) => {
    if (facts !== before) history.add(sampleOf(state, facts, nowMs()));
  });
  onChange(
    () => state.link.value.is,
    (is) => mark("link", t(LINK[is])),
  );
  onChange(
    () => turnOf(state),
    (turn) => mark("turn", t(TURN[turn.split(" ")[0] as Turn])),
  );
  onChange(
    () => state.stopNumber.value,
    (stop) => mark("stop", t(stop === null ? "stats.stop.released" : "stats.stop.pressed")),
  );
  onChange(
    () => said(state.driveReason.value),
    (reason) => reason && mark("robot", unnamed(reason, state)),
  );
  onChange(
    () => {
      const playout = state.playout.value;
      return playout && `${policyWords(playout.policy)}: ${said(playout.reason)}`;
    },
    (policy) => policy && mark("policy", policy),
  );
  onChange(
    () => {
      const { rendition, reason } = state.served.value ?? {};
      return [rendition && sizeWords(rendition), said(reason)].filter(Boolean).join(": ");
    },
    (sent) => sent && mark("sent", sent),
  );
  onChange(
    () => state.player.value.by,
    (by) => mark("player", t(PLAYER[by])),
  );
  return history;
}

/** Calls `tell` on each change, but not with the first value. */
function onChange<T>(value: () => T, tell: (value: T) => void): void {
  let isFirst = true;
  let before: T | undefined;
  effect(() => {
    const now = value();
    if (!isFirst && now !== before) tell(now);
    isFirst = false;
    before = now;
  });
}

const LINK = {
  connecting: "stats.link.connecting",
  connected: "stats.link.connected",
  silent: "stats.link.silent",
  waiting: "stats.link.waiting",
  closed: "stats.link.closed",
} as const satisfies Record<LinkState["is"], Code>;

const TURN = {
  mine: "stats.turn.mine",
  another: "stats.turn.another",
  nobody: "stats.turn.nobody",
} as const satisfies Record<string, Code>;

type Turn = keyof typeof TURN;

const PLAYER = {
  "built-in": "stats.player.built_in",
  browser: "stats.player.browser",
} as const satisfies Record<SoundPlayerState["by"], Code>;

/** Which turn it is and whether it is this page's, without a name. */
function turnOf({ room, drivingTurn }: State): string {
  const turn = room.value?.turn;
  if (drivingTurn.value !== null) return `mine ${drivingTurn.value}`;
  return turn?.operator == null ? "nobody" : `another ${turn.number}`;
}

/** The sentence without viewers' names, because the history goes into bug reports. */
export function unnamed(sentence: string, { room }: State): string {
  const { viewers = [], stop } = room.peek() ?? {};
  const names = [...viewers.map((one) => one.name), ...(stop ? [said(stop.by)] : [])];
  return names
    .filter((name) => name.trim() !== "")
    .toSorted((a, b) => b.length - a.length)
    .reduce((text, name) => text.replaceAll(name, "…"), sentence);
}

export function sampleOf(state: State, facts: Facts, atMs: number): Sample {
  const served = state.served.peek();
  return {
    atMs,
    pictureMs: facts.pictureMs,
    soundMs: facts.soundMs,
    skewMs: facts.skewMs,
    jitterMs: facts.jitterMs,
    bufferMs: facts.bufferMs,
    roundTripMs: facts.roundTripMs,
    heldMs: state.playout.peek()?.picture_target_ms ?? null,
    linkBps: served?.link_bps ?? null,
    usedBps: served?.used_bps ?? null,
    queueMs: served?.queue_ms ?? null,
    widthPx: served && (widthOf(served.rendition) ?? 0),
    askedPx: state.preferences.peek().picture ? widthOf(state.size.peek()) : 0,
    sentHz: served && (served.rendition === null ? 0 : served.picture_hz),
    arrivedHz: facts.arrivedFps,
    shownHz: facts.fps,
  };
}

/** Of `640x480 at 500 kbit/s`: 640. */
function widthOf(rendition: string | null | undefined): number | null {
  const width = Number.parseInt(rendition ?? "", 10);
  return Number.isNaN(width) ? null : width;
}
