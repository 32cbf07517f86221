/** Answers the server's offer, for a browser that never makes one; loaded only there. */

import { within } from "../within";
import { pageSentence } from "../words/said";
import { packed, RequestError } from "./http";
import { gathered, postOffer } from "./signalling";

/** Sets a session description, in whatever form this browser takes it. */
type SetLocal = (description: RTCSessionDescriptionInit) => Promise<void>;

/**
 * Applies the server's offer, and returns the transceivers of sound and picture, before anything
 * arrives; `mayHaveVoice` leaves room for a voice.
 */
export async function takeOffer(
  pc: RTCPeerConnection,
  sdp: string,
  mayHaveVoice: boolean,
): Promise<{ sound: RTCRtpTransceiver; picture: RTCRtpTransceiver }> {
  await within("setRemoteDescription", pc.setRemoteDescription({ type: "offer", sdp }));
  const all = pc.getTransceivers();
  const of = (kind: string) => all.find(({ receiver }) => receiver.track.kind === kind);
  const [sound, picture] = [of("audio"), of("video")];
  if (!sound || !picture) throw new RequestError(pageSentence("link.no_description"), true);
  if (mayHaveVoice) sound.direction = "sendrecv";
  return { sound, picture };
}

/** Answers the offer that was taken. */
export async function sendAnswer(
  pc: RTCPeerConnection,
  client: string,
  { setLocal, gathers, signal }: { setLocal: SetLocal; gathers: boolean; signal: AbortSignal },
): Promise<void> {
  const answer = await within("createAnswer", pc.createAnswer());
  await within("setLocalDescription", setLocal(answer));
  if (gathers) await gathered(pc);
  const sdp = pc.localDescription?.sdp ?? "";
  await postOffer(await packed({ sdp, client, answers: true }), signal);
}
