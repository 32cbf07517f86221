/** Peers that are not bound to one address of this device. */

import { isFramed } from "../framed";

let frame: HTMLIFrameElement | undefined;

/**
 * Creates a peer whose sockets survive a change of the device's address.
 *
 * Chromium binds the sockets of a document that may use the microphone to the interfaces'
 * addresses: they die with an address, and a new one is noticed 1.5 s late. So an empty frame that
 * may not use the microphone creates the peers. Other browsers work differently, and lack
 * `featurePolicy`; a page in another site's frame may not speak anyway.
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
