/** What goes over HTTP before there is a connection. */

const UNREACHABLE = "The server cannot be reached.";
const ASKING_MS = 2000;
const GATHERING_MS = 2000;

/** The server said no, or nothing; the message is a sentence for a person. */
export class SignallingError extends Error {}

/** The ICE servers to use: none unless configured, nor when there is no answer in two seconds. */
export async function askIceServers(): Promise<RTCIceServer[]> {
  try {
    const response = await fetch("/api/ice", { signal: AbortSignal.timeout(ASKING_MS) });
    return response.ok ? (await response.json()).iceServers : [];
  } catch {
    return [];
  }
}

/** Posts the offer and returns the answer's text; throws `SignallingError`. */
export async function postOffer(sdp: string, client: string, signal: AbortSignal): Promise<string> {
  let response: Response;
  try {
    response = await fetch("/api/offer", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ sdp, client }),
      signal,
    });
  } catch {
    throw new SignallingError(UNREACHABLE);
  }
  const body = await response.json().catch(() => null);
  if (response.ok && typeof body?.sdp === "string") return body.sdp;
  throw new SignallingError(
    typeof body?.error === "string" ? body.error : `The server answered ${response.status}.`,
  );
}

/** Waits until all candidates are known, two seconds at most: the rest would not help. */
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
