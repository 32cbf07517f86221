/** The HTTP requests before there is a connection. */

import { post, RequestError } from "./http";

const ASKING_MS = 2000;
const GATHERING_MS = 2000;

/** The ICE servers: none unless configured, or without an answer within two seconds. */
export async function askIceServers(): Promise<RTCIceServer[]> {
  try {
    const response = await fetch("/api/ice", { signal: AbortSignal.timeout(ASKING_MS) });
    return response.ok ? (await response.json()).iceServers : [];
  } catch {
    return [];
  }
}

/** Posts the offer and returns the answer's text; throws `RequestError`. */
export async function postOffer(sdp: string, client: string, signal: AbortSignal): Promise<string> {
  const answer = await post("/api/offer", { sdp, client }, { signal });
  if (typeof answer.sdp === "string") return answer.sdp;
  throw new RequestError("The server answered with no session description.", true);
}

/** Waits until all candidates are known, but at most two seconds. */
export function gathered(pc: RTCPeerConnection): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, GATHERING_MS);
    const look = () => {
      if (pc.iceGatheringState !== "complete") return;
      clearTimeout(timer);
      resolve();
    };
    pc.addEventListener("icegatheringstatechange", look);
    look();
  });
}
