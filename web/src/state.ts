/** What the page shows: signals, and what is computed from them. */

import { computed, type ReadonlySignal, type Signal, signal } from "@preact/signals";
import type { MissedCall } from "./call";
import { NO_PADS, type PadState } from "./drive/gamepads";
import type { Direction, Motion } from "./drive/inputState";
import { type KeyMap, keysInForce } from "./drive/keyMap";
import type { ScanItem } from "./drive/scanner";
import type { LinkState } from "./link/link";
import { isNeededForDriving } from "./link/thin";
import type { Breaks } from "./measure/breaks";
import type {
  AboardInfo,
  CameraInfo,
  Console,
  Ended,
  Hello,
  InvitationLink,
  Playout,
  RoomState,
  Sentence,
  Served,
  ViewerInfo,
} from "./messages";
import { type Permissions, permissions } from "./permissions";
import type { Preferences } from "./preferences";
import type { Proof } from "./proof";
import type { Output } from "./sound/outputs";
import type { SoundPlayerState } from "./sound/soundPlayback";
import { SILENT, type Voice } from "./voice/talk";
import type { Box } from "./wantedSize";
import type { Saying } from "./words/said";

/** Measurements of the streams and the link, for people to read; null if unknown. */
export interface Facts {
  pictureMs: number | null;
  /** The largest possible error of `pictureMs`. */
  pictureErrorMs: number | null;
  soundMs: number | null;
  /** How much later than the picture the sound plays; known even where the ages are not. */
  skewMs: number | null;
  roundTripMs: number | null;
  /** How unevenly the packets of sound arrive (RFC 3550). */
  jitterMs: number | null;
  /** How long the sound waits in its player's buffer. */
  bufferMs: number | null;
  /** Pictures that arrive, and that are presented, a second. */
  arrivedFps: number | null;
  fps: number | null;
  pauses: Breaks | null;
  freezes: Breaks | null;
}

const NO_FACTS: Facts = {
  pictureMs: null,
  pictureErrorMs: null,
  soundMs: null,
  skewMs: null,
  roundTripMs: null,
  jitterMs: null,
  bufferMs: null,
  arrivedFps: null,
  fps: null,
  pauses: null,
  freezes: null,
};

const MINUTE_MS = 60_000;

/** What opens beside or below the picture, one at a time. */
export type Panel = "people" | "settings" | "details" | "rules" | "host";

/** Everything that the page shows, as signals and values computed from them. */
export interface State extends Permissions {
  link: Signal<LinkState>;
  hello: Signal<Hello | null>;
  room: Signal<RoomState | null>;
  /** Whether this page watches a LiveKit room, where it cannot drive. */
  isInRoom: Signal<boolean>;
  /** How many people watch, where not all are named; null where all are. */
  watching: Signal<number | null>;
  /** Other sites' pages where the robot can be watched while the server is full. */
  links: Signal<readonly string[]>;
  /** Why the robot does not move, or moves more slowly than commanded, while this page drives. */
  driveReason: Signal<Sentence | null>;
  /** The share of the commanded speed that the server allows: 0 while it holds the robot. */
  driveShare: Signal<number>;
  /** The newest notice; always a new object, so that a repeated text shows again. */
  notice: Signal<{ text: Saying } | null>;
  preferences: Signal<Preferences>;
  /** Whether the sound plays; never before the user has touched Start. */
  isSoundOn: Signal<boolean>;
  /** Whether the large Start button is still shown. */
  isStartOffered: Signal<boolean>;
  facts: Signal<Facts>;
  /** The buffer targets, and what is sent; null before the server's first message. */
  playout: Signal<Playout | null>;
  served: Signal<Served | null>;
  /** The largest picture that this page has asked for, as `640x480`; null before the greeting. */
  size: Signal<string | null>;
  /** What the driving view fills, in pixels of CSS; null until it has been drawn. */
  box: Signal<Box | null>;
  /** The number of the large camera; null while the driving view is large. */
  large: Signal<number | null>;
  /** Cameras that have not shown a new picture for a while. */
  staleCameras: Signal<ReadonlySet<number>>;
  /** The device on which the sound plays; null for the browser's own choice. */
  output: Signal<Output | null>;
  /** Which player plays the sound. */
  player: Signal<SoundPlayerState>;
  held: Signal<ReadonlySet<Direction>>;
  /** What all controls together ask for. */
  motion: Signal<Motion>;
  /** Whether any control is held, even one that moves nothing. */
  isHolding: Signal<boolean>;
  /** What is offered to a user who drives by switches; null for nothing. */
  scan: Signal<ScanItem | null>;
  pads: Signal<PadState>;
  axes: Signal<Readonly<Record<string, number>>>;
  /** Which of the robot's controls are held here. */
  heldControls: Signal<ReadonlySet<string>>;
  /** Values that this page has set and the room does not show yet. */
  wantedControls: Signal<Readonly<Record<string, number>>>;
  /** Whether a stop was released while this page drives, and nothing was pressed since then. */
  isFreshlyReleased: Signal<boolean>;
  /** The progress of the proof of the stop; null before the host has asked. */
  proof: Signal<Proof | null>;
  /** Why this page may not stay; null while it may. */
  ended: Signal<Ended | null>;
  /** What only the host sees; null for everybody else. */
  console: Signal<Console | null>;
  /** The newest invitation that the host has asked for. */
  invitation: Signal<InvitationLink | null>;
  /** Why the link that opened the page does not work; null if it does, or once dismissed. */
  entryProblem: Signal<Saying | null>;
  /** The newest request of the person aboard, shown for a while; always a new object. */
  request: Signal<{ asked: NonNullable<AboardInfo["asked"]> } | null>;
  /** The panel that is open; null for none. */
  panel: Signal<Panel | null>;
  /** Whether this viewer's turn has ended a moment ago. */
  isTurnJustOver: Signal<boolean>;
  /** The turn that this viewer may still disown; null for none. */
  drivenTurn: Signal<number | null>;
  /** What this user is going to do, for the recording. */
  task: Signal<string>;
  /** What became of this viewer's place after the last missed call. */
  missedCall: Signal<MissedCall>;
  /** The state of this page's own microphone. */
  voice: Signal<Voice>;
  /** Both clocks, updated a few times a second, for countdowns. */
  pageMs: Signal<number>;
  serverMs: Signal<number | null>;

  /** Whether there is a connection, even a silent one. */
  isConnected: ReadonlySignal<boolean>;
  /** Whether nothing has arrived over the connection recently. */
  isSilent: ReadonlySignal<boolean>;
  /** Whether the robot can. */
  movesSideways: ReadonlySignal<boolean>;
  /** The user's keys, as they work on this robot. */
  keys: ReadonlySignal<KeyMap>;
  /** The cameras other than the driving view. */
  cameras: ReadonlySignal<readonly CameraInfo[]>;
  me: ReadonlySignal<ViewerInfo | null>;
  operator: ReadonlySignal<ViewerInfo | null>;
  /** The turn's number while this page drives, else null. */
  drivingTurn: ReadonlySignal<number | null>;
  /** Whether driving needs the whole link, so that nothing more may be loaded. */
  isLinkForDriving: ReadonlySignal<boolean>;
  /** The number of the stop in force, null for none. */
  stopNumber: ReadonlySignal<number | null>;
  /** Whether this page has pressed Stop and the server has not confirmed it in time. */
  isStopUnconfirmed: Signal<boolean>;
  /** Whether the host lets nobody see or hear anything now. */
  isBlanked: ReadonlySignal<boolean>;
  /** When the host's message ends, by this page's clock to the minute; null for no end. */
  messageEndsMs: ReadonlySignal<number | null>;
  /** Whole seconds left of the current turn, null when nobody drives. */
  secondsLeft: ReadonlySignal<number | null>;
  /** Whole seconds left to answer the call to a turn; null if there is no call. */
  callSecondsLeft: ReadonlySignal<number | null>;
}

export function createState(kept: Preferences): State {
  const link = signal<LinkState>({ is: "connecting", reason: null });
  const hello = signal<Hello | null>(null);
  const room = signal<RoomState | null>(null);
  const serverMs = signal<number | null>(null);
  const isInRoom = signal(false);

  const isSilent = computed(() => link.value.is === "silent");
  const isConnected = computed(() => link.value.is === "connected" || isSilent.value);
  const viewer = (id: number | null | undefined) =>
    room.value?.viewers.find((one) => one.id === id) ?? null;

  const me = computed(() => viewer(hello.value?.viewer));
  const isHere = computed(() => isConnected.value && !isInRoom.value);
  const stopNumber = computed(() => room.value?.stop?.number ?? null);
  const drivingTurn = computed(() => {
    const turn = room.value?.turn;
    const mine = turn !== undefined && turn.operator === hello.value?.viewer;
    return isHere.value && mine ? turn.number : null;
  });

  const served = signal<Served | null>(null);
  const preferences = signal(kept);
  const movesSideways = computed(() => (hello.value?.robot.max_lateral_mps ?? 0) > 0);

  return {
    link,
    hello,
    room,
    isInRoom,
    watching: signal(null),
    links: signal([]),
    driveReason: signal(null),
    driveShare: signal(1),
    notice: signal(null),
    preferences,
    isSoundOn: signal(false),
    isStartOffered: signal(kept.sound),
    facts: signal(NO_FACTS),
    playout: signal(null),
    large: signal(null),
    staleCameras: signal(new Set<number>()),
    output: signal(null),
    player: signal({ by: "browser", why: null }),
    served,
    size: signal(null),
    box: signal(null),
    held: signal(new Set<Direction>()),
    motion: signal({ linear: 0, angular: 0 }),
    isHolding: signal(false),
    scan: signal(null),
    pads: signal(NO_PADS),
    axes: signal({}),
    heldControls: signal(new Set<string>()),
    wantedControls: signal({}),
    isFreshlyReleased: signal(false),
    proof: signal(null),
    ended: signal(null),
    console: signal(null),
    invitation: signal(null),
    entryProblem: signal(null),
    request: signal(null),
    panel: signal("people"),
    isTurnJustOver: signal(false),
    drivenTurn: signal(null),
    task: signal(""),
    missedCall: signal(null),
    voice: signal(SILENT),
    pageMs: signal(0),
    serverMs,
    isConnected,
    isSilent,
    movesSideways,
    keys: computed(() => keysInForce(preferences.value.keys, movesSideways.value)),
    cameras: computed(() => (isInRoom.value ? [] : (hello.value?.cameras ?? []))),
    me,
    operator: computed(() => viewer(room.value?.turn.operator)),
    drivingTurn,
    isLinkForDriving: computed(() => isNeededForDriving(served.value, drivingTurn.value)),
    stopNumber,
    isStopUnconfirmed: signal(false),
    ...permissions({ hello, room, me, drivingTurn, isHere }),
    isBlanked: computed(() => room.value?.host_settings.blanked === true),
    messageEndsMs: computed(() => {
      const endsMs = room.value?.host_settings.message_ends_server_ms ?? null;
      if (endsMs === null || serverMs.value === null) return null;
      return Math.round((Date.now() + endsMs - serverMs.value) / MINUTE_MS) * MINUTE_MS;
    }),
    callSecondsLeft: computed(() => {
      const call = room.value?.call;
      const isMine = call && isConnected.value && call.viewer === hello.value?.viewer;
      if (!isMine || serverMs.value === null) return null;
      return secondsUntil(call.until_server_ms, serverMs.value, Number.POSITIVE_INFINITY);
    }),
    secondsLeft: computed(() => {
      const standsMs = room.value?.turn.stands_left_ms ?? null;
      if (standsMs !== null) return Math.ceil(standsMs / 1000);
      const endsMs = room.value?.turn.ends_server_ms ?? null;
      if (endsMs === null || serverMs.value === null) return null;
      return secondsUntil(endsMs, serverMs.value, hello.value?.turn_s ?? Number.POSITIVE_INFINITY);
    }),
  };
}

/** The seconds left, rounded up; never more than a turn, never below 0. */
export function secondsUntil(endsMs: number, nowMs: number, turnS: number): number {
  const seconds = Math.ceil((endsMs - nowMs) / 1000);
  return Math.max(0, Math.min(seconds, Math.ceil(turnS)));
}
