/** The page's sentences, as pure functions. */

import type { Asked } from "../aboard";
import type { MissedCall } from "../call";
import type { LinkState } from "../link/link";
import type { CameraInfo, Hello, RoomState, Served, StopInfo, ViewerInfo } from "../messages";
import type { Voice } from "../voice/talk";
import { named } from "../words/named";
import { said } from "../words/said";
import { type Code, locale, t } from "../words/words";

/** The connection, for the status line. */
export function connectionWords(link: LinkState, nowMs: number): string {
  switch (link.is) {
    case "connected":
      return t("link.connected");
    case "silent": {
      const seconds = Math.max(1, Math.floor((nowMs - link.sinceMs) / 1000));
      return t("link.no_answer_for", { seconds: String(seconds) });
    }
    case "connecting":
      return link.reason === null
        ? t("link.connecting")
        : t("link.reconnecting", { reason: said(link.reason) });
    case "closed":
      return t("link.not_connected");
    case "waiting": {
      const seconds = Math.max(0, Math.ceil((link.retryAtMs - nowMs) / 1000));
      return seconds > 0
        ? t("link.reconnecting_in", { seconds: String(seconds), reason: said(link.reason) })
        : t("link.reconnecting_now", { reason: said(link.reason) });
    }
  }
}

/** The connection for screen readers: without the status line's seconds, which are not read out. */
export function toldWords(link: LinkState, saysPicture: boolean): string {
  // A picture already says that it is not live.
  if (link.is === "silent") return saysPicture ? "" : t("link.no_answer");
  const reason = link.is === "waiting" || link.is === "connecting" ? link.reason : null;
  return reason === null ? "" : t("link.reconnecting", { reason: said(reason) });
}

/** A rough waiting time: `about 40 s`, `about 2 min`. */
export function waitWords(waitS: number | null): string {
  if (waitS === null) return "";
  if (waitS <= 10) return t("queue.soon");
  if (waitS < 55) return t("queue.about_s", { seconds: Math.round(waitS / 10) * 10 });
  return t("queue.about_min", { minutes: String(Math.max(1, Math.round(waitS / 60))) });
}

/** The text beside a name in the list of viewers. */
export function placeWords(viewer: ViewerInfo): string {
  const lost = viewer.lost ? [t("queue.lost")] : [];
  switch (viewer.role) {
    case "operator":
      return [t("queue.drives"), ...lost].join(", ");
    case "observer":
      return [t("queue.watches"), ...lost].join(", ");
    case "queued": {
      const wait = waitWords(viewer.wait_s);
      const place =
        viewer.place === 1 ? t("queue.next") : t("queue.number", { place: viewer.place ?? "?" });
      return [place, ...(wait ? [wait] : []), ...lost].join(", ");
    }
  }
}

/** All viewers in order: the operator, the queue, the observers. */
export function inOrder(viewers: readonly ViewerInfo[]): ViewerInfo[] {
  const rank = (viewer: ViewerInfo) => viewer.place ?? Number.POSITIVE_INFINITY;
  return viewers.toSorted((a, b) => (rank(a) === rank(b) ? a.id - b.id : rank(a) - rank(b)));
}

/** The turn from this viewer's point of view: a headline, and what comes next. */
export interface TurnWords {
  headline: string;
  next: string;
}

/** For a viewer who has lost the connection: how long their turn or place is kept. */
export function lostWords(me: ViewerInfo | null, graceS: number): TurnWords {
  if (!me) return { headline: t("turn.one_moment"), next: "" };
  const kept = LOST[me.role];
  const next = kept ? t(kept, { seconds: String(graceS) }) : "";
  return { headline: t("turn.connection_lost"), next };
}

const LOST = {
  operator: "turn.keep_turn",
  queued: "turn.keep_place",
  observer: null,
} as const;

/** What to say after a call that this viewer did not answer. */
export function missedWords(missed: MissedCall): string | null {
  switch (missed) {
    case "kept":
      return t("turn.missed_once");
    case "lost":
      return t("turn.missed_twice");
    case null:
      return null;
  }
}

/** Whether the picture's age is unknown, whatever its capture time says. */
export function isUndated(room: RoomState | null): boolean {
  return Boolean(room?.video.undated);
}

/** Why the turn's clock is stopped; null while it runs. */
export function standingWords(room: RoomState | null): string | null {
  if (!room || room.turn.stands_left_ms === null) return null;
  if (room.host_settings.blanked) return t("turn.stands_blanked");
  if (room.stop) return t("turn.stands_stopped");
  if (hasHand(room)) return t("turn.stands_aboard");
  if (room.robot.problem !== null || !room.robot.connected) return t("turn.stands_robot");
  return room.video.problem !== null ? t("turn.stands_picture") : t("turn.stands");
}

function hasHand({ aboard }: RoomState): boolean {
  return aboard !== null && aboard.mode !== "free" && aboard.mode !== "lost";
}

/** A request of the person aboard, in their words. */
export function requestWords(asked: Asked): string {
  return t(REQUESTS[asked]);
}

const REQUESTS = {
  wait: "aboard.wait",
  go_on: "aboard.go_on",
  left: "aboard.left",
  right: "aboard.right",
} as const satisfies Record<Asked, Code>;

/** When something happens, in the reader's own time: `today at 14:00`, `on Tuesday at 9:00`. */
export function whenWords(wallMs: number, nowMs: number, where = locale()): string {
  const at = new Date(wallMs);
  const time = at.toLocaleTimeString(where, TIME);
  const midnight = new Date(nowMs).setHours(0, 0, 0, 0);
  const days = Math.round((new Date(wallMs).setHours(0, 0, 0, 0) - midnight) / DAY_MS);
  if (days === 0) return t("when.today", { time });
  if (days === 1) return t("when.tomorrow", { time });
  const isSoon = days < 7;
  const day = at.toLocaleDateString(
    where,
    isSoon ? { weekday: "long" } : { day: "numeric", month: "long" },
  );
  return t("when.on", { day, time });
}

const DAY_MS = 86_400_000;
export const TIME = { hour: "numeric", minute: "2-digit" } as const;

export function turnWords(room: RoomState | null, me: ViewerInfo | null): TurnWords {
  if (!room || !me) return { headline: t("turn.one_moment"), next: "" };
  const operator = room.viewers.find((viewer) => viewer.role === "operator");
  const first = room.viewers.find((viewer) => viewer.place === 1);
  if (me.role === "operator") {
    return {
      headline: t("turn.you_drive"),
      next: first ? t("turn.then", { name: named(first.name) }) : t("turn.nobody_else"),
    };
  }
  const held = room.host_settings.held;
  const name = operator ? named(operator.name) : "";
  if (me.role === "queued") {
    const driving = operator ? t("turn.while_drives", { name }) : t("turn.while_nobody");
    return { headline: ownPlaceWords(me), next: held ? t("turn.paused") : driving };
  }
  const driving = operator ? t("turn.drives", { name }) : t("turn.nobody_drives");
  const waiting = room.viewers.filter((viewer) => viewer.role === "queued").length;
  if (held) return { headline: driving, next: t("turn.paused") };
  return { headline: driving, next: operator ? waitingWords(waiting) : t("turn.free") };
}

function ownPlaceWords({ place }: ViewerInfo): string {
  return place === 1 ? t("turn.you_next") : t("turn.you_number", { place: place ?? "?" });
}

function waitingWords(count: number): string {
  return count === 0 ? t("turn.nobody_waits") : t("turn.waiting", { n: count });
}

/** How many people watch, if there are too many to name. */
export function watchingWords(count: number): string {
  return t("queue.watching", { n: count });
}

/** How to get a turn, shown below controls that do not work yet. */
export function joinWords(me: ViewerInfo | null, mayQueue = true): string {
  if (!mayQueue) return notInvited();
  return me?.role === "queued" ? t("turn.wait_for_it") : t("turn.join_to_drive");
}

/** Who stopped the robot, and who can release the stop. */
export function stoppedWords(
  room: RoomState | null,
  stop: StopInfo,
  me: ViewerInfo | null,
  mayRelease: boolean,
): TurnWords {
  const operator = room?.viewers.find((viewer) => viewer.role === "operator");
  const other = operator && operator.id !== me?.id ? named(operator.name) : null;
  const others = other === null ? "operator" : "other";
  const who = mayRelease ? "you" : stop.by_host ? "host" : others;
  // With a person aboard, a stop blocks everybody else, but not them.
  const until = (room?.aboard ? ABOARD_UNTIL : UNTIL)[who];
  return {
    headline:
      stop.viewer !== null && stop.viewer === me?.id
        ? t("stop.by_you")
        : t("stop.by", { name: said(stop.by) }),
    next: t(until, { name: other ?? "" }),
  };
}

const UNTIL = {
  you: "stop.until_you",
  other: "stop.until_other",
  operator: "stop.until_operator",
  host: "stop.until_host",
} as const;

const ABOARD_UNTIL = {
  you: "stop.aboard_until_you",
  other: "stop.aboard_until_other",
  operator: "stop.aboard_until_operator",
  host: "stop.aboard_until_host",
} as const;

/** For uninvited viewers, who may watch but not drive or hear. */
export function notInvited(): string {
  return t("turn.not_invited");
}

/** Why this page never has sound; null if it has. */
export function silenceWords(hello: Hello | null): string | null {
  if (hello?.has_microphone === false) return t("robot.no_microphone");
  return hello?.may_hear === false ? t("robot.not_heard") : null;
}

export function blanked(): string {
  return t("robot.blanked");
}

/** For an operator after the stop was released, until they press a control. */
export function released(): string {
  return t("stop.released");
}

/** Why there is no picture or sound, or the robot cannot move, in the server's sentences. */
export function problemWords(room: RoomState | null): string[] {
  if (!room) return [];
  const { robot, video, audio } = room;
  const isLost = robot.problem === null && !robot.connected;
  return [
    ...(robot.problem ? [t("robot.problem", { problem: said(robot.problem) })] : []),
    ...(isLost ? [t("robot.not_connected")] : []),
    ...(robot.bumpers ? [t("robot.bumper")] : []),
    ...(video.problem ? [t("robot.camera", { problem: said(video.problem) })] : []),
    ...(video.undated ? [said(video.undated)] : []),
    ...(audio.problem ? [t("robot.microphone", { problem: said(audio.problem) })] : []),
  ];
}

export function drivingView(): string {
  return t("robot.driving_view");
}

/** Why a camera other than the driving view shows nothing; null if there is no reason. */
export function cameraProblem(
  at: number,
  room: RoomState | null,
  served: Served | null,
): string | null {
  const problem = room?.cameras[at]?.problem;
  if (problem) return said(problem);
  const isLeftOut = served !== null && served.cameras[at] == null;
  return isLeftOut ? t("robot.camera_left_out") : null;
}

/** An axis's name, with the camera that it moves. */
export function axisWords(axis: string, cameras: readonly CameraInfo[]): string {
  const camera = cameras.find((one) => one.axes.includes(axis));
  return camera ? t("robot.axis", { axis, camera: camera.name }) : axis;
}

/** Who else speaks through the robot; empty if nobody does. */
export function speakerWords(room: RoomState | null, me: number): string {
  const speaker = room?.voice?.speaker ?? null;
  if (speaker === null || speaker === me) return "";
  const viewer = room?.viewers.find((one) => one.id === speaker);
  return viewer ? t("voice.speaks", { name: named(viewer.name) }) : t("voice.somebody_speaks");
}

/** Why the user's own voice is not heard; null if no reason is known. */
export function voiceProblem(voice: Voice, room: RoomState | null): string | null {
  if (voice.problem !== null) return said(voice.problem);
  if (room?.voice?.problem) return said(room.voice.problem);
  return room?.voice?.muted ? t("voice.muted") : null;
}

/** The state of the user's own voice, and of the robot's sound meanwhile, if it has any. */
export function voiceWords(voice: Voice, hello: Hello): string {
  const own = voice.isHeard ? t("voice.heard") : t("voice.on");
  const isSilent = silenceWords(hello) !== null;
  const robots = isSilent ? "" : t("voice.ducked");
  return (voice.isOn ? `${own} ${robots}` : robots).trim();
}
