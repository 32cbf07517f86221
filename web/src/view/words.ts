/** The page's sentences, as pure functions. */

import type { Asked } from "../aboard";
import type { MissedCall } from "../call";
import type { LinkState } from "../link/link";
import type {
  CameraInfo,
  ConsoleViewer,
  Hello,
  RobotStatus,
  RoomState,
  Served,
  StopInfo,
  ViewerInfo,
} from "../messages";
import type { Voice } from "../voice/talk";

/** The connection, for the status line. */
export function connectionWords(link: LinkState, nowMs: number): string {
  switch (link.is) {
    case "connected":
      return "Connected";
    case "silent": {
      const seconds = Math.max(1, Math.floor((nowMs - link.sinceMs) / 1000));
      return `No answer for ${seconds} s`;
    }
    case "connecting":
      return link.reason === null ? "Connecting…" : `Reconnecting… ${link.reason}`;
    case "closed":
      return "Not connected";
    case "waiting": {
      const seconds = Math.max(0, Math.ceil((link.retryAtMs - nowMs) / 1000));
      return `Reconnecting ${seconds > 0 ? `in ${seconds} s` : "now"}: ${link.reason}`;
    }
  }
}

/** A rough waiting time: `about 40 s`, `about 2 min`. */
export function waitWords(waitS: number | null): string {
  if (waitS === null) return "";
  if (waitS <= 10) return "any moment now";
  if (waitS < 55) return `about ${Math.round(waitS / 10) * 10} s`;
  return `about ${Math.max(1, Math.round(waitS / 60))} min`;
}

/** The text beside a name in the queue. */
export function placeWords(viewer: ViewerInfo): string {
  const lost = viewer.lost ? ["connection lost"] : [];
  switch (viewer.role) {
    case "operator":
      return ["driving", ...lost].join(", ");
    case "observer":
      return ["watching", ...lost].join(", ");
    case "queued": {
      const wait = waitWords(viewer.wait_s);
      const place = viewer.place === 1 ? "next" : `number ${viewer.place}`;
      return [place, ...(wait ? [wait] : []), ...lost].join(", ");
    }
  }
}

/** Everybody in the order of the queue: who drives, who waits, who watches. */
export function inOrder(viewers: readonly ViewerInfo[]): ViewerInfo[] {
  const rank = (viewer: ViewerInfo) => viewer.place ?? Number.POSITIVE_INFINITY;
  return viewers.toSorted((a, b) => (rank(a) === rank(b) ? a.id - b.id : rank(a) - rank(b)));
}

/** The turn from this viewer's point of view: a headline, and what comes next. */
export interface TurnWords {
  headline: string;
  next: string;
}

/** For a viewer whose connection is lost: how long their turn or place is kept. */
export function lostWords(me: ViewerInfo | null, graceS: number): TurnWords {
  if (!me) return { headline: "One moment…", next: "" };
  const what = { operator: "turn", queued: "place", observer: null }[me.role];
  const next = what ? `Come back within ${graceS} s to keep your ${what}.` : "";
  return { headline: "Connection lost", next };
}

/** After a call that this viewer did not answer. */
export function missedWords(missed: MissedCall): string | null {
  switch (missed) {
    case "kept":
      return "You did not answer, so the next person drives. Your place is kept this once.";
    case "lost":
      return "You did not answer twice, so your place went to the next person. Join again.";
    case null:
      return null;
  }
}

/** Why the clock of a turn stands still; null while it runs. */
export function standingWords(room: RoomState | null): string | null {
  if (!room || room.turn.stands_left_ms === null) return null;
  const why = room.house.blanked
    ? "the host has switched picture and sound off"
    : room.stop
      ? "the robot is stopped"
      : hasHand(room)
        ? "the person aboard has the robot"
        : room.robot.problem !== null || !room.robot.connected
          ? "the robot does not answer"
          : room.video.problem !== null
            ? "there is no picture"
            : "nobody can drive";
  return `The clock stands still while ${why}.`;
}

function hasHand({ aboard }: RoomState): boolean {
  return aboard !== null && aboard.mode !== "free" && aboard.mode !== "lost";
}

/** A request of the person aboard, as they would say it. */
export function requestWords(asked: Asked): string {
  return REQUESTS[asked];
}

const REQUESTS = {
  wait: "Please wait.",
  go_on: "Please go on.",
  left: "To the left, please.",
  right: "To the right, please.",
} as const satisfies Record<Asked, string>;

/** What the host sees of a viewer's connection: `42 ms, 640 × 480`. */
export function qualityWords(line: ConsoleViewer): string {
  const words = [
    ...(line.round_trip_ms === null ? [] : [`${Math.round(line.round_trip_ms)} ms there and back`]),
    ...(line.picture_ms === null ? [] : [`picture ${Math.round(line.picture_ms)} ms old`]),
    ...(line.rendition === null ? ["no picture"] : [line.rendition.replace("x", " × ")]),
  ];
  return words.join(", ");
}

/** When something happens, in the reader's own time: `today at 14:00`, `on Tuesday at 9:00`. */
export function whenWords(wallMs: number, nowMs: number, locale?: string): string {
  const at = new Date(wallMs);
  const time = at.toLocaleTimeString(locale, { hour: "numeric", minute: "2-digit" });
  const midnight = new Date(nowMs).setHours(0, 0, 0, 0);
  const days = Math.round((new Date(wallMs).setHours(0, 0, 0, 0) - midnight) / DAY_MS);
  if (days === 0) return `today at ${time}`;
  if (days === 1) return `tomorrow at ${time}`;
  if (days < 7) return `on ${at.toLocaleDateString(locale, { weekday: "long" })} at ${time}`;
  return `on ${at.toLocaleDateString(locale, { day: "numeric", month: "long" })} at ${time}`;
}

const DAY_MS = 86_400_000;

/** A name in a sentence: one that is written from right to left leaves the rest in order. */
export function named(name: string): string {
  return RIGHT_TO_LEFT.test(name) ? `\u2068${name}\u2069` : name;
}

const RIGHT_TO_LEFT = /[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]/;

export function turnWords(room: RoomState | null, me: ViewerInfo | null): TurnWords {
  if (!room || !me) return { headline: "One moment…", next: "" };
  const operator = room.viewers.find((viewer) => viewer.role === "operator");
  const first = room.viewers.find((viewer) => viewer.place === 1);
  if (me.role === "operator") {
    return {
      headline: "You are driving",
      next: first ? `Then it is ${named(first.name)}'s turn.` : "Nobody else is waiting.",
    };
  }
  const held = room.house.held;
  const driving = operator ? `${named(operator.name)} is driving` : "Nobody is driving";
  if (me.role === "queued") {
    const wait = waitWords(me.wait_s);
    const place = me.place === 1 ? "You are next" : `You are number ${me.place} in the queue`;
    return { headline: wait ? `${place}, ${wait}` : place, next: held ? PAUSED : `${driving}.` };
  }
  const waiting = room.viewers.filter((viewer) => viewer.role === "queued").length;
  if (held) return { headline: driving, next: PAUSED };
  return { headline: driving, next: operator ? waitingWords(waiting) : "The robot is free." };
}

const PAUSED = "The queue is paused: the host lets nobody begin.";

function waitingWords(count: number): string {
  if (count === 0) return "Nobody is waiting.";
  return count === 1 ? "One person is waiting." : `${count} people are waiting.`;
}

/** How many watch, where there are too many to name. */
export function watchingWords(count: number): string {
  return count === 1 ? "One person watches." : `${count.toLocaleString("en")} people watch.`;
}

/** How to get to drive, below controls that do not work yet. */
export function joinWords(me: ViewerInfo | null, mayQueue = true): string {
  if (!mayQueue) return NOT_INVITED;
  return me?.role === "queued" ? "You drive when it is your turn." : "Join the queue to drive.";
}

/** Who stopped the robot, and who can release the stop. */
export function stoppedWords(
  room: RoomState | null,
  stop: StopInfo,
  me: ViewerInfo | null,
  mayRelease: boolean,
): TurnWords {
  const operator = room?.viewers.find((viewer) => viewer.role === "operator");
  const who = operator && operator.id !== me?.id ? named(operator.name) : "the operator";
  // Who sits in the robot is left stranded by nobody.
  const what = room?.aboard ? "Only the person aboard may drive" : "Nothing moves";
  return {
    headline: `Stopped by ${named(stop.by)}`,
    next: `${what} until ${mayRelease ? "you release it" : `${who} or the host releases it`}.`,
  };
}

/** Where strangers may watch, but not drive or hear. */
export const NOT_INVITED = "Only invited people drive here. Ask the host for a link.";
const NO_MICROPHONE = "This robot has no microphone.";
const NOT_HEARD = "Only invited people hear this robot.";

/** Why this page never has sound; null if it has. */
export function silenceWords(hello: Hello | null): string | null {
  if (hello?.has_microphone === false) return NO_MICROPHONE;
  return hello?.may_hear === false ? NOT_HEARD : null;
}

export const BLANKED = "The host has switched picture and sound off for a moment.";

/** For an operator who held a control while the stop was released. */
export const RELEASED = "Released. Let go of everything, then press again to drive.";

/** The battery's charge and voltage, as far as the robot reports them; null if it does not. */
export function batteryWords({ battery_v, battery_fraction }: RobotStatus): string | null {
  const words = [
    ...(battery_fraction === null ? [] : [`${Math.round(battery_fraction * 100)} %`]),
    ...(battery_v === null ? [] : [`${battery_v.toFixed(1)} V`]),
  ];
  return words.length === 0 ? null : words.join(", ");
}

/** Why there is no picture, no sound or no moving robot: sentences from the server. */
export function problemWords(room: RoomState | null): string[] {
  if (!room) return [];
  const robot = room.robot.problem ?? (room.robot.connected ? null : "it is not connected");
  return [
    ...(robot ? [`Robot: ${robot}`] : []),
    ...(room.robot.bumpers ? ["Robot: a bumper is pressed"] : []),
    ...(room.video.problem ? [`Camera: ${room.video.problem}`] : []),
    ...(room.audio.problem ? [`Microphone: ${room.audio.problem}`] : []),
  ];
}

export const DRIVING_VIEW = "Driving view";

/** Why nothing is seen of a camera beside the driving view; null if there is no reason. */
export function cameraProblem(
  at: number,
  room: RoomState | null,
  served: Served | null,
): string | null {
  const problem = room?.cameras[at]?.problem;
  if (problem) return problem;
  const isLeftOut = served !== null && served.cameras[at] == null;
  return isLeftOut ? "Your connection carries no more." : null;
}

/** What an axis moves, by whose camera it is. */
export function axisWords(axis: string, cameras: readonly CameraInfo[]): string {
  const camera = cameras.find((one) => one.axes.includes(axis));
  return camera ? `${axis} of ${camera.name}` : axis;
}

/** Who speaks through the robot, for everybody but themselves; empty if nobody does. */
export function speakerWords(room: RoomState | null, me: number): string {
  const speaker = room?.voice?.speaker ?? null;
  if (speaker === null || speaker === me) return "";
  const viewer = room?.viewers.find((one) => one.id === speaker);
  return `${viewer ? named(viewer.name) : "Somebody"} is speaking to the people beside the robot.`;
}

/** Why one's own voice is not heard; null where nothing is known that keeps it from that. */
export function voiceProblem(voice: Voice, room: RoomState | null): string | null {
  if (voice.problem !== null) return voice.problem;
  if (room?.voice?.problem) return room.voice.problem;
  return room?.voice?.muted ? "The host has muted all voices." : null;
}

/** What becomes of one's own voice, and meanwhile of the robot's sound, where there is any. */
export function voiceWords(voice: Voice, hello: Hello): string {
  const own = voice.isHeard ? "You are heard." : "The microphone is on.";
  const isSilent = silenceWords(hello) !== null;
  const robots = isSilent ? "" : "While you speak, you do not hear the robot; the others do.";
  return (voice.isOn ? `${own} ${robots}` : robots).trim();
}
