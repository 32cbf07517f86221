import type { Receivers } from "../measure/report";
import type { Seat, Told } from "../messages";
import { Failover, isSameRoom } from "./failover";
import { LiveKitRoom } from "./livekitRoom";
import { enough, type RenditionChoice } from "./rendition";

export interface WatchEvents {
  /** Show these receivers: a room has started to play, or plays something else. */
  show(receivers: Receivers): void;
  told(told: Told): void;
  /** Whether the wanted streams arrive; while they do not, another room is tried. */
  plays(isPlaying: boolean): void;
  /** No room plays, or this page was sent away: the robot's server must be asked again. */
  failed(): void;
}

export interface WatchOptions {
  rendition: RenditionChoice;
  wants: () => { sound: boolean; picture: boolean };
  /** The size that is enough, as `640x480`. */
  size: () => string;
  /** Whether the robot has a picture to send. */
  isPictureExpected: () => boolean;
  events: WatchEvents;
}

/** How long a room may take to its first picture; over a slow link it needs a dozen round trips. */
const OPENS_MS = 4000;
/** How long another rendition may take to its first picture. */
const SWITCHES_MS = 2000;

const NOTHING: Receivers = { sound: null, picture: null };

interface Tried {
  room: LiveKitRoom;
  sinceMs: number;
}

/**
 * Watches one LiveKit room, and switches to another when it fails; the old picture stays on the
 * screen until the new one has arrived.
 */
export class Watch {
  readonly #failover = new Failover();
  #room: LiveKitRoom | null = null;
  #next: Tried | null = null;
  #shown = NOTHING;
  /** The picture awaited for the screen, and its newest RTP time when it was subscribed. */
  #coming: { receiver: RTCRtpReceiver; rtp: number | undefined } | null = null;
  /** The publisher whose picture was requested last, and when. */
  #target: { name: string | null; sinceMs: number } = { name: null, sinceMs: 0 };
  #newestRtp: number | undefined;
  #isResting = false;
  #isPlaying = false;

  constructor(private readonly options: WatchOptions) {}

  /** Whether there is a room, even a resting one. */
  get hasRoom(): boolean {
    return this.#room !== null;
  }

  /** Sets the rooms to watch, or fresh tokens for them; enters one unless a room plays. */
  offer(seats: Seat[], nowMs: number): void {
    this.#failover.offer(seats);
    if (!this.#room && !this.#next) this.#go(nowMs);
  }

  /** Stays in the room but receives nothing until `resume`. */
  rest(): void {
    this.#isResting = true;
    this.#next?.room.leave();
    this.#next = null;
    this.#room?.watch(null, false);
    this.#clear();
  }

  /** Receives picture and sound again; `show` follows once they arrive. */
  resume(nowMs: number): void {
    this.#isResting = false;
    this.#target = { name: null, sinceMs: nowMs };
    this.#failover.restartWait(nowMs);
  }

  leave(): void {
    this.#room?.leave();
    this.#next?.room.leave();
    this.#room = this.#next = null;
    this.#isResting = false;
    this.#clear();
  }

  /** Checks the rooms; call it several times a second. */
  check(nowMs: number): void {
    if (this.#isResting) return;
    if (this.#next) this.#try(this.#next, nowMs);
    if (this.#room) this.#follow(this.#room, nowMs);
  }

  // --- the next room -------------------------------------------------------------------------

  #go(nowMs: number): void {
    const seat = this.#failover.next();
    if (!seat) {
      this.options.events.failed();
      return;
    }
    if (this.#room && isSameRoom(seat, this.#room.seat)) {
      this.#room.leave();
      this.#room = null;
    }
    const room: LiveKitRoom = new LiveKitRoom(seat, {
      told: (told) => {
        if (room === this.#room || !this.#room) this.options.events.told(told);
      },
      gone: (isSentAway) => this.#gone(room, isSentAway),
    });
    this.#coming = null;
    this.#next = { room, sinceMs: nowMs };
  }

  #try({ room, sinceMs }: Tried, nowMs: number): void {
    const picture = this.#choose(room, nowMs);
    const isNeeded = this.options.wants().picture && this.options.isPictureExpected();
    if (isNeeded ? this.#hasCome(picture) : room.isConnected) {
      this.#room?.leave();
      this.#room = room;
      this.#next = null;
      this.options.rendition.forget();
      this.#failover.plays(room.seat, nowMs);
      this.#show({ sound: room.sound, picture });
      this.#play(true);
    } else if (nowMs - sinceMs >= OPENS_MS) {
      this.#leaveNext(room, nowMs);
    }
  }

  #leaveNext(room: LiveKitRoom, nowMs: number): void {
    room.leave();
    this.#next = null;
    this.#failover.failed(room.seat);
    this.#go(nowMs);
  }

  #gone(room: LiveKitRoom, isSentAway: boolean): void {
    const nowMs = performance.now();
    if (isSentAway && room !== this.#next?.room) {
      this.leave();
      this.options.events.failed();
    } else if (room === this.#next?.room) {
      this.#leaveNext(room, nowMs);
    } else if (room === this.#room) {
      this.#break(room, nowMs);
    }
  }

  /** Handles a failure of the room on the screen; its last picture stays for now. */
  #break(room: LiveKitRoom, nowMs: number): void {
    this.#failover.failed(room.seat);
    if (this.#isResting) {
      this.leave();
      return;
    }
    if (!room.isConnected) this.#room = null;
    this.#play(false);
    if (!this.#next) this.#go(nowMs);
  }

  // --- the room on the screen ----------------------------------------------------------------

  #follow(room: LiveKitRoom, nowMs: number): void {
    if (this.#next) return; // this room has been given up
    const picture = this.#choose(room, nowMs);
    const { sound } = room;
    const isOff = !this.options.wants().picture;
    const isOther = picture !== this.#shown.picture;
    // A resumed room shows nothing until its picture is subscribed again.
    const isFirst = !isOff && this.#shown.picture === null && this.options.isPictureExpected();
    // The previous picture stays until the other one has arrived.
    if (isOther && (isOff || this.#hasCome(picture))) {
      this.#show({ sound, picture });
    } else if (sound !== this.#shown.sound && !isFirst) {
      this.#show({ ...this.#shown, sound });
    }
    const isSwitching = !isOff && (isFirst || picture !== this.#shown.picture);
    const mayStand = isSwitching && nowMs - this.#target.sinceMs < SWITCHES_MS;
    const moves = this.#moves();
    if (moves) this.#play(true);
    if (this.#failover.hasStood(nowMs, moves || mayStand)) this.#break(room, nowMs);
  }

  /** Whether new media has arrived since the last call, or none is expected. */
  #moves(): boolean {
    const { wants, isPictureExpected } = this.options;
    const { picture, sound } = wants();
    const isPictureDue = picture && isPictureExpected();
    // Not every robot has a microphone.
    if (!isPictureDue && !(sound && this.#shown.sound)) return true;
    const rtp = newestOf(isPictureDue ? this.#shown.picture : this.#shown.sound);
    const isNew = rtp !== undefined && rtp !== this.#newestRtp;
    this.#newestRtp = rtp;
    return isNew;
  }

  /** Subscribes to what is wanted; returns the picture's receiver, null while there is none. */
  #choose(room: LiveKitRoom, nowMs: number): RTCRtpReceiver | null {
    const { wants, size, rendition } = this.options;
    const { sound, picture } = wants();
    const names = room.pictures;
    const name = (rendition.isSmall ? names.at(-1) : enough(names, size())) ?? null;
    if (name !== null && name !== this.#target.name) this.#target = { name, sinceMs: nowMs };
    room.watch(picture ? name : null, sound);
    return picture && name !== null ? room.picture(name) : null;
  }

  /** Whether a new frame has arrived; receivers are reused, so the newest may be an old one. */
  #hasCome(receiver: RTCRtpReceiver | null): boolean {
    if (receiver === null) return false;
    if (this.#coming?.receiver !== receiver) {
      this.#coming = { receiver, rtp: newestOf(receiver) };
    }
    const rtp = newestOf(receiver);
    return rtp !== undefined && rtp !== this.#coming.rtp;
  }

  /** Forgets what is on the screen. */
  #clear(): void {
    this.#shown = NOTHING;
    this.#coming = null;
    this.#isPlaying = false;
  }

  #play(isPlaying: boolean): void {
    if (isPlaying === this.#isPlaying) return;
    this.#isPlaying = isPlaying;
    this.options.events.plays(isPlaying);
  }

  #show(receivers: Receivers): void {
    this.#shown = receivers;
    this.#coming = null;
    this.options.events.show(receivers);
  }
}

/** The RTP time of the newest frame or packet that was handed to the track. */
function newestOf(receiver: RTCRtpReceiver | null): number | undefined {
  return receiver?.getSynchronizationSources()[0]?.rtpTimestamp;
}
