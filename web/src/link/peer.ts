/** One connection, from its offer to its end; when another takes its place: `link.ts`. */

import type { Channel, Ended } from "../messages";
import { withVoice } from "../voice/answer";
import { ENCODINGS, type VoiceEncoding } from "../voice/encoding";
import { Unsettled, within } from "../within";
import { pageSentence, type Saying, says } from "../words/said";
import { packed, RequestError } from "./http";
import { askIce, gathered, postOffer, type Sent } from "./signalling";
import { withStereo } from "./stereo";
import { makePeer } from "./unbound";

/** A peer's events; there are none after `lost` or `close`. */
export interface PeerEvents {
  /** The server can be reached. */
  reached(): void;
  /** The offer was sent. */
  offered(): void;
  /** The server has accepted this peer, and dropped this page's earlier one. */
  answered(): void;
  /** Both data channels are open. */
  opened(): void;
  received(channel: Channel, text: string): void;
  /** The peer has failed; the server may ask to wait this long before the next. */
  lost(reason: Saying, retryAfterMs: number | null): void;
  /** The server does not admit this page. */
  refused(ended: Ended): void;
  /** The server is full, and names LiveKit rooms instead. */
  sent(where: Sent): void;
  /** The receivers have just been created; transforms must be attached now. */
  receivers(sound: RTCRtpReceiver, picture: RTCRtpReceiver): void;
}

/**
 * With more than this queued a set-point would arrive late, so it is not sent at all. It is the size
 * of two set-points; each one queued ahead of a release delays it by 40 ms on a modem's uplink.
 */
const MAX_WAITING_BYTES = 256;
/** Half of what other steps may take: the server's offer takes the other half. */
const OFFER_MS = 2000;

/**
 * One RTCPeerConnection: sound and pictures in, two data channels, and room for a voice. A reconnect
 * is a new peer.
 */
export class Peer {
  /** This browser never makes an offer, so that it takes the server's. */
  static cannotOffer = false;
  sound!: RTCRtpReceiver;
  /** The driving view. */
  picture!: RTCRtpReceiver;
  /** The cameras beside it, in the server's order; none in the server's offer. */
  cameras: readonly RTCRtpReceiver[] = [];
  readonly #pc: RTCPeerConnection;
  /** Sends the voice; created at the start, so that speaking needs no new offer. */
  #voice: RTCRtpSender | null = null;
  #answer: string | null = null;
  #isForHost = false;
  #encoding: VoiceEncoding | undefined = ENCODINGS[0];
  #shaping: Promise<void> = Promise.resolve();
  readonly #channels: Record<Channel, RTCDataChannel>;
  readonly #aborting = new AbortController();

  /** `mayHaveVoice`: the server accepts voices; `cameras`: how many besides the driving view. */
  constructor(
    private readonly events: PeerEvents,
    private readonly mayHaveVoice = false,
    cameras = 0,
  ) {
    const pc = makePeer({ bundlePolicy: "max-bundle" });
    this.#pc = pc;
    if (!Peer.cannotOffer) {
      const direction = mayHaveVoice ? "sendrecv" : "recvonly";
      const sound = pc.addTransceiver("audio", { direction });
      this.#receive(sound, receivesPictures(pc));
      this.cameras = Array.from({ length: cameras }, () => receivesPictures(pc));
    }
    this.#channels = {
      drive: pc.createDataChannel("drive", { ordered: false, maxRetransmits: 0 }),
      state: pc.createDataChannel("state"),
    };
    for (const [name, channel] of Object.entries(this.#channels)) {
      this.#listen(name as Channel, channel);
    }
    this.#on(pc, "connectionstatechange", () => {
      if (pc.connectionState === "failed" || pc.connectionState === "closed")
        this.#lose(this.#hasOpened ? pageSentence("link.lost") : this.trouble);
    });
  }

  /**
   * Sends the offer, once `mayOffer` is settled, and applies the answer; a failure is reported as
   * `lost`.
   */
  async connect(client: string, mayOffer?: Promise<void>): Promise<void> {
    const pc = this.#pc;
    const { signal } = this.#aborting;
    try {
      const [ice, offer] = await Promise.all([
        askIce(signal),
        Peer.cannotOffer ? null : within("createOffer", pc.createOffer(), OFFER_MS),
      ]).catch((error) => {
        Peer.cannotOffer ||= error instanceof Unsettled;
        throw error;
      });
      if (signal.aborted) return;
      this.events.reached();
      const { iceServers, relayOnly } = ice;
      if (iceServers.length > 0) {
        const iceTransportPolicy = relayOnly ? "relay" : "all";
        pc.setConfiguration({ ...pc.getConfiguration(), iceServers, iceTransportPolicy });
      }
      // Without ICE servers there is nothing to wait for: our checks tell the server our address.
      const gathers = iceServers.length > 0 && ice.wantsCandidates;
      if (offer) {
        await this.#does("setLocalDescription", this.#setLocal(offer));
        if (gathers) await gathered(pc);
      }
      const request = await packed({ sdp: pc.localDescription?.sdp ?? "", client });
      await mayOffer;
      if (signal.aborted) return;
      const answering = postOffer(request, signal);
      this.events.offered();
      const answer = await answering;
      if (signal.aborted) return;
      if (!("sdp" in answer)) {
        this.close();
        this.events.sent(answer);
        return;
      }
      this.#answer = answer.sdp;
      this.#isForHost = answer.isForHost;
      if (!offer) {
        const { sendAnswer, takeOffer } = await import("./answering");
        const { sound, picture } = await takeOffer(pc, answer.sdp, this.mayHaveVoice);
        if (signal.aborted) return;
        this.#receive(sound, picture.receiver);
        this.events.answered();
        const setLocal = (one: RTCSessionDescriptionInit) => this.#setLocal(one);
        await sendAnswer(pc, client, { setLocal, gathers, signal });
        return;
      }
      this.events.answered();
      const description = { type: "answer", sdp: this.#shaped(answer.sdp) } as const;
      await this.#does("setRemoteDescription", pc.setRemoteDescription(description));
    } catch (error) {
      const refusal = error instanceof RequestError ? error : null;
      if (refusal?.ended && !signal.aborted) {
        this.close();
        this.events.refused(refusal.ended);
        return;
      }
      // No `instanceof`: the peer belongs to another frame, and so do its errors.
      const text = (error as Partial<Error> | null)?.message;
      const why = typeof text === "string" ? says(text) : pageSentence("link.lost");
      const saying = error instanceof Unsettled ? error.saying : refusal?.saying;
      this.#lose(saying ?? why, refusal?.retryAfterMs ?? null);
    }
  }

  /** Receives by these, to which transforms must be attached now. */
  #receive(sound: RTCRtpTransceiver, picture: RTCRtpReceiver): void {
    this.sound = sound.receiver;
    this.picture = picture;
    if (this.mayHaveVoice) this.#voice = sound.sender;
    this.events.receivers(this.sound, picture);
  }

  /** Awaits a step of the browser's own; one that it never finishes ends this peer. */
  async #does<T>(api: string, step: Promise<T>): Promise<T> {
    return within(api, step).catch((error) => {
      if (error instanceof Unsettled) this.#lose(error.saying);
      throw error;
    });
  }

  /** Why this peer is given up, by how far it has come. */
  get trouble(): Saying {
    if (this.#answer === null || this.#hasOpened) return pageSentence("link.no_answer");
    const { iceConnectionState } = this.#pc;
    const isThrough = iceConnectionState === "connected" || iceConnectionState === "completed";
    if (isThrough) return pageSentence("link.no_dtls");
    if (!this.#isForHost) return pageSentence("link.no_udp");
    return pageSentence("link.no_udp_host", { port: portsOf(this.#answer) });
  }

  get #hasOpened(): boolean {
    return this.#channels.state.readyState !== "connecting";
  }

  /** The payload type of redundant sound (RFC 2198), null if there is none. */
  get redundancy(): number | null {
    const found = /^a=rtpmap:(\d+) red\/48000/m.exec(this.#pc.remoteDescription?.sdp ?? "");
    return found ? Number(found[1]) : null;
  }

  /** Sends this track as the voice, null for none. Rejects if the connection has ended. */
  async speak(track: MediaStreamTrack | null): Promise<void> {
    await this.#voice?.replaceTrack(track);
  }

  /**
   * Changes the voice's encoding by applying the same answer with other parameters for it; the
   * server is not involved, and nothing else changes. A browser that never finishes
   * a step would not end the voice either (`speak` waits for it), so this peer is given up, as in
   * `connect`.
   */
  shape(encoding: VoiceEncoding): void {
    if (!this.#voice || encoding === this.#encoding || Peer.cannotOffer) return;
    this.#encoding = encoding;
    this.#shaping = this.#shaping.then(() => this.#reshape(encoding)).catch(() => {});
  }

  async #reshape(encoding: VoiceEncoding): Promise<void> {
    const pc = this.#pc;
    const isLate = encoding !== this.#encoding || pc.signalingState !== "stable";
    if (this.#answer === null || this.#aborting.signal.aborted || isLate) return;
    const offer = await this.#does("createOffer", pc.createOffer());
    await this.#does("setLocalDescription", this.#setLocal(offer));
    try {
      const description = { type: "answer", sdp: this.#shaped(this.#answer) } as const;
      await this.#does("setRemoteDescription", pc.setRemoteDescription(description));
    } catch {
      // A browser that refuses the change keeps the previous encoding.
      await this.#does("setLocalDescription", pc.setLocalDescription({ type: "rollback" }));
    }
  }

  /** Sets our description with stereo sound; unchanged where the browser does not allow that. */
  async #setLocal(ours: RTCSessionDescriptionInit): Promise<void> {
    const stereo = { type: ours.type, sdp: withStereo(ours.sdp ?? "") };
    await this.#pc.setLocalDescription(stereo).catch(() => this.#pc.setLocalDescription(ours));
  }

  #shaped(answer: string): string {
    return this.#voice && this.#encoding ? withVoice(answer, this.#encoding) : answer;
  }

  /** Whether the server follows this peer to another address (one port, ICE-lite). */
  get mayMove(): boolean {
    return /^a=ice-lite/m.test(this.#answer ?? "");
  }

  /** The bytes queued on the drive channel. */
  get waitingBytes(): number {
    return this.#channels.drive.bufferedAmount;
  }

  /**
   * Sends at once or not at all, and returns which; an `urgent` message even behind a backlog.
   */
  send(channel: Channel, text: string, urgent = false): boolean {
    const to = this.#channels[channel];
    if (to.readyState !== "open") return false;
    if (channel === "drive" && !urgent && to.bufferedAmount > MAX_WAITING_BYTES) return false;
    try {
      to.send(text);
      return true;
    } catch {
      // The buffer is full; a connection that loses state messages is useless.
      if (channel === "state") this.#lose(pageSentence("link.lost"));
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
    this.#on(channel, "close", () => this.#lose(pageSentence("link.lost")));
  }

  #on(target: EventTarget, type: string, listener: (event: Event) => void): void {
    target.addEventListener(type, listener, { signal: this.#aborting.signal });
  }

  #lose(reason: Saying, retryAfterMs: number | null = null): void {
    if (this.#aborting.signal.aborted) return;
    this.close();
    this.events.lost(reason, retryAfterMs);
  }
}

/** Offers only codecs that servers send: the offer grows with each camera, and uplinks are thin. */
function receivesPictures(pc: RTCPeerConnection): RTCRtpReceiver {
  const transceiver = pc.addTransceiver("video", { direction: "recvonly" });
  const all = RTCRtpReceiver.getCapabilities("video")?.codecs ?? [];
  const sent = all.filter(({ mimeType }) => /\/(vp8|h264|rtx)$/i.test(mimeType));
  transceiver.setCodecPreferences?.(sent);
  return transceiver.receiver;
}

/** The UDP ports in the server's answer, usually one (RFC 8839, 5.1). */
function portsOf(answer: string): string {
  const found = answer.matchAll(/^a=candidate:\S+ \d+ udp \d+ \S+ (\d+) /gim);
  return [...new Set(Array.from(found, ([, port]) => port))].join(", ");
}
