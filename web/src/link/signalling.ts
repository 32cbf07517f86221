/** The HTTP requests before there is a connection. */

import { isFramed } from "../framed";
import type { SentToRoom } from "../messages";
import { ours } from "../words/said";
import { type Asked, ask, packed, RequestError, timed } from "./http";

const GATHERING_MS = 2000;
/** A relay takes more round trips than an address does: what has not come by then will not come. */
const AFTER_RELAY_MS = 200;

/** What the host configured of STUN and TURN servers. */
export interface Ice {
  servers: RTCIceServer[];
  /** Only the relay may be used, even where a direct connection is possible. */
  relayOnly: boolean;
  /** The server checks the offer's candidates, which take a moment to learn from those servers. */
  wantsCandidates: boolean;
}

/** The answer to an offer; whether the server takes this page for the host's. */
export interface Answered {
  sdp: string;
  isForHost: boolean;
}

/** Where to watch instead, and when that was asked. */
export type Sent = SentToRoom & Asked;

const NO_ICE: Ice = { servers: [], relayOnly: false, wantsCandidates: false };

/**
 * The ICE servers, none unless configured; throws `RequestError` if the server cannot be reached.
 *
 * That is why it is asked before each offer: what is sent into a dead network may arrive much
 * later, and a late offer would end the connection that has been made meanwhile.
 */
export async function askIce(signal: AbortSignal): Promise<Ice> {
  try {
    const { iceServers, ...rest } = await ask("api/ice", { signal });
    return { servers: iceServers, ...rest } as unknown as Ice;
  } catch (error) {
    if (!(error instanceof RequestError)) throw error;
    if (!error.isRefusal || error.ended || error.retryAfterMs !== null) throw error;
    return NO_ICE;
  }
}

/** The request with an offer: packed, it takes a modem a second less. */
export const offerOf = (sdp: string, client: string) => packed({ sdp, client });

/**
 * Posts the offer and returns the answer, or where to watch instead; throws `RequestError`.
 */
export async function postOffer(
  request: RequestInit,
  signal: AbortSignal,
): Promise<Answered | Sent> {
  const answer = await timed(ask(isFramed() ? "api/embed" : "api/offer", { ...request, signal }));
  if (typeof answer.sdp === "string") return { sdp: answer.sdp, isForHost: answer.host === true };
  if (answer.type === "sent_to_room") return answer as unknown as Sent;
  throw new RequestError(ours("link.no_description"), true);
}

/** Waits until all candidates are known; at most two seconds, and not for what blocked UDP keeps. */
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
