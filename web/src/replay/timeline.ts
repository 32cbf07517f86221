/** The state at each moment of one part of the tape. Pure; times in ms since its beginning. */

import type {
  Commanded,
  Placed,
  Reported,
  Steered,
  Stopped,
  TapeContent,
  Turned,
  Watched,
} from "../messages";
import { named } from "../words/named";
import { figure, t } from "../words/words";
import { endWords, reasonWords } from "./reasons";

type Event = Placed["event"];
type Type = Event["type"];
type Of<T extends Type> = Extract<Event, { type: T }>;

export interface At<E> {
  atMs: number;
  event: E;
}

/** A moment of interest. */
export interface Mark {
  atMs: number;
  kind: "stop" | "fault" | "turn" | "gap";
  words: string;
}

/** How old picture and sound were for the operator; 0 where unknown. */
export interface Ages {
  pictureMs: number;
  soundMs: number;
}

/** How long a command counts at most. */
const COMMAND_MS = 2000;
/** How long a viewer's report is shown; it covers the last second. */
const REPORT_MS = 3000;
/** A media element's time is truncated to microseconds, so it may be just before the time set. */
const CUT_MS = 0.01;
/** Marks closer together than this count as one when stepping between them. */
const STEP_MS = 50;

/** An open part of the tape. */
export interface OpenPart {
  content: TapeContent;
  timeline: Timeline;
}

export class Timeline {
  readonly lengthMs: number;
  readonly marks: readonly Mark[];
  /** The commands in the order in which the gate saw them, and in which they were sent. */
  readonly commands: readonly At<Commanded>[];
  readonly sent: readonly At<Commanded>[];
  readonly steered: readonly At<Steered>[];
  /** Those of `commands` that the gate let pass. */
  readonly counted: readonly At<Commanded>[];
  readonly watched: readonly At<Watched>[];
  readonly #sentBy: ReadonlyMap<number, At<Commanded>[]>;
  readonly #watchedBy: ReadonlyMap<number, At<Watched>[]>;
  readonly #reported: readonly At<Reported>[];
  readonly #turned: readonly At<Turned>[];
  readonly #stopped: readonly At<Stopped>[];
  readonly #names = new Map<number, string>();

  constructor(content: TapeContent) {
    this.lengthMs = content.length_ms;
    this.commands = all(content, "commanded");
    this.sent = this.commands
      .map(({ atMs, event }) => ({ atMs: atMs - event.age_ms, event }))
      .toSorted((a, b) => a.atMs - b.atMs);
    this.counted = this.commands.filter((one) => one.event.refused === null);
    this.#sentBy = byViewer(this.sent);
    this.steered = all(content, "steered");
    this.watched = all(content, "watched");
    this.#watchedBy = byViewer(this.watched);
    this.#reported = all(content, "reported");
    this.#turned = all(content, "turned");
    this.#stopped = all(content, "stopped");
    for (const { event } of all(content, "named")) this.#names.set(event.viewer, event.name);
    this.marks = content.events.flatMap((one) => this.#mark(one));
  }

  /** Who drives, null for nobody. */
  operatorAt(atMs: number): number | null {
    return newest(this.#turned, atMs)?.event.operator ?? null;
  }

  /** The operator's newest command that had counted by then. */
  commandAt(atMs: number): Commanded | null {
    return recent(this.counted, atMs, COMMAND_MS);
  }

  /** What the operator was doing then, whatever became of the command. */
  sentAt(atMs: number): Commanded | null {
    return recent(this.#of(this.#sentBy, atMs), atMs, COMMAND_MS);
  }

  steeredAt(atMs: number): Steered | null {
    return newest(this.steered, atMs)?.event ?? null;
  }

  reportedAt(atMs: number): Reported | null {
    return newest(this.#reported, atMs)?.event ?? null;
  }

  /** The stop in force, null for none. */
  stopAt(atMs: number): Stopped | null {
    const stop = newest(this.#stopped, atMs)?.event;
    return stop?.pressed ? stop : null;
  }

  /** The operator's connection, picture and sound. */
  watchedAt(atMs: number): Watched | null {
    return recent(this.#of(this.#watchedBy, atMs), atMs, REPORT_MS);
  }

  agesAt(atMs: number): Ages {
    const watched = this.watchedAt(atMs);
    return { pictureMs: watched?.picture_ms ?? 0, soundMs: watched?.sound_ms ?? 0 };
  }

  /** When the operator saw the picture of this moment, or heard its sound. */
  whenSeen(mediaMs: number, of: keyof Ages): number {
    let atMs = mediaMs;
    // Ages change slowly: a few iterations find the moment that is its own age later.
    for (let round = 0; round < 3; round++) atMs = mediaMs + this.agesAt(atMs)[of];
    return atMs;
  }

  /** The next mark after this moment; null if there is none. */
  next(atMs: number): Mark | null {
    return this.marks.find((one) => one.atMs > atMs + STEP_MS) ?? null;
  }

  previous(atMs: number): Mark | null {
    return this.marks.findLast((one) => one.atMs < atMs - STEP_MS) ?? null;
  }

  /** What somebody is called here: their name where it was recorded, else their number. */
  who(viewer: number | null): string {
    if (viewer === null) return t("replay.who.nobody");
    const name = this.#names.get(viewer);
    return name === undefined ? t("replay.who.viewer", { number: `${viewer}` }) : named(name);
  }

  /** The entries of the viewer who drives at this moment. */
  #of<E>(found: ReadonlyMap<number, At<E>[]>, atMs: number): readonly At<E>[] {
    const operator = this.operatorAt(atMs);
    return (operator !== null && found.get(operator)) || [];
  }

  #mark({ at_ms, event }: Placed): Mark[] {
    // The state before this part is repeated at its beginning, and is no event.
    const isNews = at_ms > 0;
    const mark = (kind: Mark["kind"], words: string) => [{ atMs: at_ms, kind, words }];
    switch (event.type) {
      case "stopped": {
        if (!isNews) return [];
        if (!event.pressed) return mark("stop", t("replay.stop.released"));
        const who = event.by_host ? t("replay.who.host") : this.who(event.viewer);
        return mark("stop", t("replay.stop.pressed", { who }));
      }
      case "faulted":
        return mark("fault", t("replay.fault", { why: reasonWords(event.why) }));
      case "turned":
        if (!isNews) return [];
        return event.operator === null
          ? mark("turn", t("replay.turn.ends", { why: endWords(event.why) }))
          : mark("turn", t("replay.turn.begins", { who: this.who(event.operator) }));
      case "missed":
        return mark("gap", t("replay.gap", { seconds: figure(event.missed_s, 1) }));
      default:
        return [];
    }
  }
}

function all<T extends Type>(content: TapeContent, type: T): At<Of<T>>[] {
  return content.events.flatMap(({ at_ms, event }) =>
    event.type === type ? [{ atMs: at_ms, event: event as Of<T> }] : [],
  );
}

function byViewer<E extends { viewer: number }>(found: readonly At<E>[]): Map<number, At<E>[]> {
  const sorted = new Map<number, At<E>[]>();
  for (const one of found) {
    const own = sorted.get(one.event.viewer);
    if (own) own.push(one);
    else sorted.set(one.event.viewer, [one]);
  }
  return sorted;
}

/** The newest entry that is not later; null if all are later. */
export function newest<E>(found: readonly At<E>[], atMs: number): At<E> | null {
  let from = 0;
  let to = found.length;
  while (from < to) {
    const middle = (from + to) >> 1;
    if ((found[middle]?.atMs ?? 0) <= atMs + CUT_MS) from = middle + 1;
    else to = middle;
  }
  return found[from - 1] ?? null;
}

function recent<E>(found: readonly At<E>[], atMs: number, withinMs: number): E | null {
  const one = newest(found, atMs);
  return one && atMs - one.atMs <= withinMs ? one.event : null;
}
