/** Peers that do not hang on one address of this device. */

import { isFramed } from "../framed";

let frame: HTMLIFrameElement | undefined;

/**
 * Makes a peer whose sockets go on from whatever address the device gets.
 *
 * Chromium binds the sockets of a document that may use the microphone to the interfaces' addresses,
 * with which they die, and learns of another address 1.5 s late. So an empty frame that may not use
 * it makes the peers. Other browsers decide otherwise, and know no `featurePolicy`; a page in another
 * site's frame may not speak anyway.
 */
export function makePeer(configuration: RTCConfiguration): RTCPeerConnection {
  if (isFramed() || !("featurePolicy" in document)) return new RTCPeerConnection(configuration);
  if (!frame?.isConnected) {
    frame = document.createElement("iframe");
    frame.hidden = true;
    frame.allow = "microphone 'none'; camera 'none'";
    document.body.append(frame);
  }
  const { RTCPeerConnection: Connection } = frame.contentWindow as unknown as typeof globalThis;
  return new Connection(configuration);
}
