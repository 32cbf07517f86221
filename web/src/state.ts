import { computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import type { Direction } from "./drive/inputState";
import type { LinkState } from "./link/link";
import type { Breaks } from "./measure/breaks";
import type { Hello, Playout, RoomState, Served, ViewerInfo } from "./messages";
import type { Preferences } from "./preferences";
import type { Proof } from "./proof";

/** What is measured of the streams and the way, for a person to read; null where unknown. */
export interface Facts {
  pictureMs: number | null;
  /** How wrong `pictureMs` can be at most. */
  pictureErrorMs: number | null;
  soundMs: number | null;
  roundTripMs: number | null;
  fps: number | null;
  pauses: Breaks | null;
  freezes: Breaks | null;
}

const NO_FACTS: Facts = {
  pictureMs: null,
  pictureErrorMs: null,
  soundMs: null,
  roundTripMs: null,
  fps: null,
  pauses: null,
  freezes: null,
};

/** Everything that the page shows. Signals change; what is computed of them follows. */
export interface State {
  link: Signal<LinkState>;
  hello: Signal<Hello | null>;
  room: Signal<RoomState | null>;
  /** Why the robot stands, or moves slower than it is told, although somebody drives it. */
  driveReason: Signal<string | null>;
  /** The newest notice; each is an object of its own, so that the same words show again. */
  notice: Signal<{ text: string } | null>;
  preferences: Signal<Preferences>;
  /** The sound plays; never before a person has asked for it by a touch. */
  isSoundOn: Signal<boolean>;
  /** The large Start button is still offered. */
  isStartOffered: Signal<boolean>;
  facts: Signal<Facts>;
  /** What the policy wants of the buffers, and what is sent; null before the server has told. */
  playout: Signal<Playout | null>;
  served: Signal<Served | null>;
  held: Signal<ReadonlySet<Direction>>;
  axes: Signal<Readonly<Record<string, number>>>;
  /** A stop was released while this page drives, and nothing was pressed since. */
  isFreshlyReleased: Signal<boolean>;
  /** How far the proof of the stop is; null before the host has asked. */
  proof: Signal<Proof | null>;
  /** Both clocks, a few times a second: for what counts down. */
  pageMs: Signal<number>;
  serverMs: Signal<number | null>;

  /** There is a connection, also while nothing comes over it. */
  isConnected: ReadonlySignal<boolean>;
  /** Nothing has come over the connection for a while. */
  isSilent: ReadonlySignal<boolean>;
  me: ReadonlySignal<ViewerInfo | null>;
  operator: ReadonlySignal<ViewerInfo | null>;
  /** The turn's number while this page drives, else null. */
  drivingTurn: ReadonlySignal<number | null>;
  /** The number of the stop that is latched, null for none. */
  stopNumber: ReadonlySignal<number | null>;
  /** This page drives and no stop is latched. */
  mayMove: ReadonlySignal<boolean>;
  /** Whoever watches, unless the server lets only operator and host; without a link, too. */
  mayStop: ReadonlySignal<boolean>;
  /** The operator, and a page on the server's own machine. */
  mayRelease: ReadonlySignal<boolean>;
  /** Whole seconds left of the turn that runs, null when nobody drives. */
  secondsLeft: ReadonlySignal<number | null>;
}

export function createState(kept: Preferences): State {
  const link = signal<LinkState>({ is: "connecting" });
  const hello = signal<Hello | null>(null);
  const room = signal<RoomState | null>(null);
  const serverMs = signal<number | null>(null);

  const isSilent = computed(() => link.value.is === "silent");
  const isConnected = computed(() => link.value.is === "connected" || isSilent.value);
  const viewer = (id: number | null | undefined) =>
    room.value?.viewers.find((one) => one.id === id) ?? null;

  const me = computed(() => viewer(hello.value?.viewer));
  const isOperator = computed(() => me.value?.role === "operator");
  const isInCharge = computed(() => isOperator.value || hello.value?.is_host === true);
  const stopNumber = computed(() => room.value?.stop?.number ?? null);
  const drivingTurn = computed(() => {
    const turn = room.value?.turn;
    const mine = turn !== undefined && turn.operator === hello.value?.viewer;
    return isConnected.value && mine ? turn.number : null;
  });

  return {
    link,
    hello,
    room,
    driveReason: signal(null),
    notice: signal(null),
    preferences: signal(kept),
    isSoundOn: signal(false),
    isStartOffered: signal(kept.sound),
    facts: signal(NO_FACTS),
    playout: signal(null),
    served: signal(null),
    held: signal(new Set<Direction>()),
    axes: signal({}),
    isFreshlyReleased: signal(false),
    proof: signal(null),
    pageMs: signal(0),
    serverMs,
    isConnected,
    isSilent,
    me,
    operator: computed(() => viewer(room.value?.turn.operator)),
    drivingTurn,
    stopNumber,
    mayMove: computed(() => drivingTurn.value !== null && stopNumber.value === null),
    mayStop: computed(() => hello.value?.on_loss.stop_by !== "operator" || isInCharge.value),
    mayRelease: isInCharge,
    secondsLeft: computed(() => {
      const endsMs = room.value?.turn.ends_server_ms ?? null;
      if (endsMs === null || serverMs.value === null) return null;
      return secondsUntil(endsMs, serverMs.value, hello.value?.turn_s ?? Number.POSITIVE_INFINITY);
    }),
  };
}

/** Whole seconds that are still (partly) left; never more than a turn has, never below 0. */
export function secondsUntil(endsMs: number, nowMs: number, turnS: number): number {
  const seconds = Math.ceil((endsMs - nowMs) / 1000);
  return Math.max(0, Math.min(seconds, Math.ceil(turnS)));
}
