/** The HTTP requests that set up a connection. */

import { isFramed } from "../framed";
import type { Answers, SentToRoom } from "../messages";
import { pageSentence } from "../words/said";
import { type Asked, ask, RequestError, timed } from "./http";

const GATHERING_MS = 2000;
/** A relay candidate takes the most round trips; after it, no others are worth waiting for. */
const AFTER_RELAY_MS = 200;

/** The answer to an offer, and whether the server takes this page for the host's. */
export interface Answered {
  sdp: string;
  isForHost: boolean;
}

/** Where to watch instead, with the times of request and answer. */
export type Sent = SentToRoom & Asked;

type Ice = Answers["api/ice"];

const NO_ICE: Ice = { iceServers: [], relayOnly: false, wantsCandidates: false };

/**
 * Requests the ICE servers, none unless configured; throws `RequestError` if the server cannot be
 * reached. That is why it comes before each offer: a request into a dead network may arrive much
 * later, and a late offer would end the connection that has been made meanwhile.
 */
export async function askIce(signal: AbortSignal): Promise<Ice> {
  try {
    return await ask("api/ice", { signal });
  } catch (error) {
    if (!(error instanceof RequestError)) throw error;
    if (!error.isRefusal || error.ended || error.retryAfterMs !== null) throw error;
    return NO_ICE;
  }
}

/**
 * Posts the offer and returns the answer, or where to watch instead; throws `RequestError`.
 */
export async function postOffer(
  request: RequestInit,
  signal: AbortSignal,
): Promise<Answered | Sent> {
  const answer = await timed(ask(isFramed() ? "api/embed" : "api/offer", { ...request, signal }));
  if ("type" in answer && answer.type === "sent_to_room") return answer;
  if ("sdp" in answer && typeof answer.sdp === "string")
    return { sdp: answer.sdp, isForHost: answer.host === true };
  throw new RequestError(pageSentence("link.no_description"), true);
}

/** Waits until all candidates are gathered, at most 2 s, and briefly once a relay's is there. */
export function gathered(pc: RTCPeerConnection): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, GATHERING_MS);
    const look = () => {
      if (pc.iceGatheringState !== "complete") return;
      clearTimeout(timer);
      resolve();
    };
    pc.addEventListener("icegatheringstatechange", look);
    pc.addEventListener("icecandidate", ({ candidate }) => {
      if (/\styp\srelay\b/.test(candidate?.candidate ?? "")) setTimeout(resolve, AFTER_RELAY_MS);
    });
    look();
  });
}
