/**
 * What the page says about the turn: every state has one face, with a headline, what comes next,
 * and why. A pure function of the state.
 */

import type { MissedCall } from "../call";
import type { LinkState } from "../link/link";
import type { Hello, RoomState, ViewerInfo } from "../messages";
import type { State } from "../state";
import { t } from "../words/words";
import {
  joinWords,
  lostWords,
  missedWords,
  standingWords,
  stoppedWords,
  type TurnWords,
  turnWords,
  waitWords,
} from "./pageWords";

/** How the card looks. */
export type Tone = "connecting" | "calm" | "driving" | "ending" | "stopped" | "trouble";

export interface Face extends TurnWords {
  tone: Tone;
  note: string | null;
  /** The estimated wait, for a queued viewer; it changes often and is not read out. */
  wait: string | null;
  /** Whether this viewer can release the stop in force. */
  releases: boolean;
  /** What the large button does; null for no button. */
  queue: "join" | "leave" | "end" | null;
}

/** What a face depends on. */
export interface Seen {
  link: LinkState;
  isConnected: boolean;
  hello: Hello | null;
  room: RoomState | null;
  me: ViewerInfo | null;
  isDriving: boolean;
  secondsLeft: number | null;
  mayRelease: boolean;
  missedCall: MissedCall;
  /** Whether this viewer's turn has just ended. */
  isJustOver: boolean;
}

/** How long before the turn's end the card warns. */
export const ENDING_S = 10;

/** The face of this state; reads signals. */
export function faceOf(state: State): Face {
  const { link, isConnected, hello, room, me, drivingTurn, secondsLeft } = state;
  return face({
    link: link.value,
    isConnected: isConnected.value,
    hello: hello.value,
    room: room.value,
    me: me.value,
    isDriving: drivingTurn.value !== null,
    secondsLeft: secondsLeft.value,
    mayRelease: state.mayRelease.value,
    missedCall: state.missedCall.value,
    isJustOver: state.isTurnJustOver.value,
  });
}

export function face(seen: Seen): Face {
  if (!seen.isConnected) return unconnected(seen);
  const { hello, room, me, isDriving, mayRelease } = seen;
  const queue = queueing(hello, me);
  const note = missedWords(seen.missedCall) ?? standingWords(room);
  const wait = (me?.role === "queued" && waitWords(me.wait_s)) || null;
  if (room?.stop) {
    const words = stoppedWords(room, room.stop, me, mayRelease);
    return { ...words, tone: "stopped", note, wait, releases: mayRelease, queue };
  }
  const words = turnWords(room, me);
  const common = { ...words, note, wait, releases: false, queue };
  if (isDriving) return { ...common, tone: isEnding(seen) ? "ending" : "driving" };
  const isInTheWay = room !== null && (room.robot.problem !== null || !room.robot.connected);
  if (isInTheWay) return { ...common, tone: "trouble" };
  if (seen.isJustOver) {
    // The headline's place in the queue, with the wait, also says when this viewer drives again.
    return { ...common, tone: "calm", headline: t("face.thanks"), next: words.headline };
  }
  if (queue === null && me?.role === "observer") {
    return { ...common, tone: "calm", note: note ?? joinWords(me, false) };
  }
  return { ...common, tone: "calm" };
}

function unconnected({ link, hello, me }: Seen): Face {
  const kept = lostWords(me, hello?.grace_s ?? 0);
  const isFirst = hello === null && link.is === "connecting" && link.reason === null;
  const words = isFirst
    ? { headline: t("face.connecting"), next: t("face.connecting_next") }
    : kept;
  return {
    ...words,
    tone: isFirst ? "connecting" : "trouble",
    note: null,
    wait: null,
    releases: false,
    queue: null,
  };
}

function queueing(hello: Hello | null, me: ViewerInfo | null): Face["queue"] {
  if (!me) return null;
  if (me.role === "operator") return "end";
  if (me.role === "queued") return "leave";
  return hello?.may_queue === false ? null : "join";
}

function isEnding({ secondsLeft }: Seen): boolean {
  return secondsLeft !== null && secondsLeft <= ENDING_S;
}
