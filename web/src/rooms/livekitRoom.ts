import {
  DisconnectReason,
  type RemoteTrackPublication,
  Room,
  RoomEvent,
  setLogLevel,
  Track,
} from "livekit-client";
import type { Seat, Told } from "../messages";
import { inQuality } from "./rendition";

/** The robot publishes under names with this prefix, one for each rendition. */
const ROBOT = "robot ";
const TOPIC = "wax";

/** A LiveKit room's events; there are none after `gone` or `leave`. */
export interface RoomEvents {
  told(told: Told): void;
  /** The connection is lost or was never made, or this page was sent away. */
  gone(isSentAway: boolean): void;
}

/** One connection to a LiveKit room. */
export class LiveKitRoom {
  readonly #room = new Room({
    // Capture times arrive only over a connection that is not shared with the page's own tracks.
    singlePeerConnection: false,
    // Never reconnect: switching to another room is faster.
    reconnectPolicy: { nextRetryDelayInMs: () => null },
  });
  #isOver = false;

  constructor(
    readonly seat: Seat,
    private readonly events: RoomEvents,
  ) {
    setLogLevel("silent");
    this.#room.on(RoomEvent.SignalReconnecting, () => this.#end(false));
    this.#room.on(RoomEvent.Reconnecting, () => this.#end(false));
    this.#room.on(RoomEvent.Disconnected, (why) => this.#end(isSentAway(why)));
    this.#room.on(RoomEvent.DataReceived, (payload, sender, _kind, topic) => {
      // The robot's server sends without being a participant; ignore everybody else.
      if (sender === undefined && topic === TOPIC) this.#hear(payload);
    });
    this.#room
      .connect(seat.url, seat.token, { autoSubscribe: false, maxRetries: 0 })
      .catch(() => this.#end(false));
  }

  /** The publishers of a picture, the best first. */
  get pictures(): string[] {
    const has = (name: string) => this.#find(name, Track.Kind.Video) !== undefined;
    const names = [...this.#room.remoteParticipants.keys()];
    return inQuality(names.filter((name) => name.startsWith(ROBOT) && has(name)));
  }

  /** Subscribes to this publisher's picture, null for none, and to the sound; to nothing else. */
  watch(picture: string | null, sound: boolean): void {
    for (const [name, one] of this.#room.remoteParticipants) {
      if (!name.startsWith(ROBOT)) continue;
      for (const [, publication] of one.trackPublications) {
        const isPicture = publication.kind === Track.Kind.Video;
        want(publication as RemoteTrackPublication, isPicture ? name === picture : sound);
      }
    }
  }

  /** The receiver of this publisher's picture, null while there is none. */
  picture(name: string): RTCRtpReceiver | null {
    return this.#find(name, Track.Kind.Video)?.track?.receiver ?? null;
  }

  get sound(): RTCRtpReceiver | null {
    for (const name of this.#room.remoteParticipants.keys()) {
      const receiver = this.#find(name, Track.Kind.Audio)?.track?.receiver;
      if (receiver && name.startsWith(ROBOT)) return receiver;
    }
    return null;
  }

  get isConnected(): boolean {
    return !this.#isOver && this.#room.state === "connected";
  }

  leave(): void {
    this.#isOver = true;
    void this.#room.disconnect();
  }

  #find(name: string, kind: Track.Kind): RemoteTrackPublication | undefined {
    const all = this.#room.remoteParticipants.get(name)?.trackPublications.values() ?? [];
    return [...all].find((one) => one.kind === kind) as RemoteTrackPublication | undefined;
  }

  #hear(payload: Uint8Array): void {
    if (this.#isOver) return;
    const told = JSON.parse(new TextDecoder().decode(payload));
    if (told.type === "told") this.events.told(told);
  }

  #end(isSentAway: boolean): void {
    if (this.#isOver) return;
    this.#isOver = true;
    this.events.gone(isSentAway);
  }
}

function want(publication: RemoteTrackPublication, isWanted: boolean): void {
  if (publication.isDesired !== isWanted) publication.setSubscribed(isWanted);
}

function isSentAway(why: DisconnectReason | undefined): boolean {
  return (
    why === DisconnectReason.PARTICIPANT_REMOVED || why === DisconnectReason.DUPLICATE_IDENTITY
  );
}
