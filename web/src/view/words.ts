/** The page's sentences, as pure functions. */

import type { LinkState } from "../link/link";
import type { RobotStatus, RoomState, StopInfo, ViewerInfo } from "../messages";

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

export function turnWords(room: RoomState | null, me: ViewerInfo | null): TurnWords {
  if (!room || !me) return { headline: "One moment…", next: "" };
  const operator = room.viewers.find((viewer) => viewer.role === "operator");
  const first = room.viewers.find((viewer) => viewer.place === 1);
  if (me.role === "operator") {
    return {
      headline: "You are driving",
      next: first ? `Then it is ${first.name}'s turn.` : "Nobody else is waiting.",
    };
  }
  const driving = operator ? `${operator.name} is driving` : "Nobody is driving";
  if (me.role === "queued") {
    const wait = waitWords(me.wait_s);
    const place = me.place === 1 ? "You are next" : `You are number ${me.place} in the queue`;
    return { headline: wait ? `${place}, ${wait}` : place, next: `${driving}.` };
  }
  const waiting = room.viewers.filter((viewer) => viewer.role === "queued").length;
  return { headline: driving, next: operator ? waitingWords(waiting) : "The robot is free." };
}

function waitingWords(count: number): string {
  if (count === 0) return "Nobody is waiting.";
  return count === 1 ? "One person is waiting." : `${count} people are waiting.`;
}

/** How to get to drive, below controls that do not work yet. */
export function joinWords(me: ViewerInfo | null): string {
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
  const who = operator && operator.id !== me?.id ? operator.name : "the operator";
  return {
    headline: `Stopped by ${stop.by}`,
    next: `Nothing moves until ${mayRelease ? "you release it" : `${who} or the host releases it`}.`,
  };
}

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
