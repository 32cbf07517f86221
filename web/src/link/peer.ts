import type { Channel } from "../messages";
import { askIceServers, gathered, postOffer } from "./signalling";

/** What a peer tells; nothing comes after `lost`, nor after `close` was called. */
export interface PeerEvents {
  /** Both data channels are open. */
  opened(): void;
  received(channel: Channel, text: string): void;
  /** `reason` is a sentence for a person. */
  lost(reason: string): void;
  /** The receivers are made; what stands between them and the tracks must be put there now. */
  receivers(sound: RTCRtpReceiver, picture: RTCRtpReceiver): void;
}

/**
 * More than this waiting to be sent: a set-point would arrive late, so it is not sent at all. Two of
 * them; whatever lies before a release delays it, on a modem's uplink by 40 ms each.
 */
const MAX_WAITING_BYTES = 256;

const LOST = "The connection was lost.";

/** One RTCPeerConnection: two tracks in, two data channels. A reconnect is a new peer. */
export class Peer {
  readonly sound: RTCRtpReceiver;
  readonly picture: RTCRtpReceiver;
  readonly #pc: RTCPeerConnection;
  readonly #channels: Record<Channel, RTCDataChannel>;
  readonly #aborting = new AbortController();

  constructor(private readonly events: PeerEvents) {
    const pc = new RTCPeerConnection({ bundlePolicy: "max-bundle" });
    this.#pc = pc;
    this.sound = pc.addTransceiver("audio", { direction: "recvonly" }).receiver;
    this.picture = pc.addTransceiver("video", { direction: "recvonly" }).receiver;
    events.receivers(this.sound, this.picture);
    this.#channels = {
      drive: pc.createDataChannel("drive", { ordered: false, maxRetransmits: 0 }),
      state: pc.createDataChannel("state"),
    };
    for (const [name, channel] of Object.entries(this.#channels)) {
      this.#listen(name as Channel, channel);
    }
    this.#on(pc, "connectionstatechange", () => {
      if (pc.connectionState === "failed" || pc.connectionState === "closed") this.#lose(LOST);
    });
  }

  /** Offers and takes the answer; a failure is told as `lost`. */
  async connect(client: string): Promise<void> {
    const pc = this.#pc;
    try {
      // Asked for every peer: an answer that failed or grew old is not kept.
      const [servers, offer] = await Promise.all([askIceServers(), pc.createOffer()]);
      if (servers.length > 0) {
        pc.setConfiguration({ ...pc.getConfiguration(), iceServers: servers });
      }
      await pc.setLocalDescription(offer);
      // Without servers there is nothing worth waiting for: ours learns our address from us.
      if (servers.length > 0) await gathered(pc);
      const text = pc.localDescription?.sdp ?? "";
      const sdp = await postOffer(text, client, this.#aborting.signal);
      await pc.setRemoteDescription({ type: "answer", sdp });
    } catch (error) {
      this.#lose(error instanceof Error ? error.message : LOST);
    }
  }

  /** What still waits to be sent over the drive channel. */
  get waitingBytes(): number {
    return this.#channels.drive.bufferedAmount;
  }

  /**
   * Sends at once or not at all, which is told; `urgent` goes even when others wait before it.
   */
  send(channel: Channel, text: string, urgent = false): boolean {
    const to = this.#channels[channel];
    if (to.readyState !== "open") return false;
    if (channel === "drive" && !urgent && to.bufferedAmount > MAX_WAITING_BYTES) return false;
    try {
      to.send(text);
      return true;
    } catch {
      // A full buffer; a state message that cannot go leaves nothing to hold on to.
      if (channel === "state") this.#lose(LOST);
      return false;
    }
  }

  close(): void {
    this.#aborting.abort();
    this.#pc.close();
  }

  #listen(name: Channel, channel: RTCDataChannel): void {
    this.#on(channel, "open", () => {
      const all = Object.values(this.#channels);
      if (all.every((one) => one.readyState === "open")) this.events.opened();
    });
    this.#on(channel, "message", (event) => {
      this.events.received(name, (event as MessageEvent<string>).data);
    });
    this.#on(channel, "close", () => this.#lose(LOST));
  }

  #on(target: EventTarget, type: string, listener: (event: Event) => void): void {
    target.addEventListener(type, listener, { signal: this.#aborting.signal });
  }

  #lose(reason: string): void {
    if (this.#aborting.signal.aborted) return;
    this.close();
    this.events.lost(reason);
  }
}
