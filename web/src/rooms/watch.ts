import type { Receivers } from "../measure/report";
import type { Seat, Told } from "../messages";
import { Failover, isSameRoom } from "./failover";
import { LiveKitRoom } from "./livekitRoom";
import type { RenditionChoice } from "./rendition";

export interface WatchEvents {
  /** A room plays, or plays something else: these are to be shown. */
  show(receivers: Receivers): void;
  told(told: Told): void;
  /** Whether there is a picture, or whatever is wanted; without one another room is tried. */
  plays(isPlaying: boolean): void;
  /** No other room plays, or this page was sent away: the robot's server has to be asked. */
  failed(): void;
}

export interface WatchOptions {
  rendition: RenditionChoice;
  wants: () => { sound: boolean; picture: boolean; isSmall: boolean };
  /** Whether the robot has a picture to send. */
  isPictureExpected: () => boolean;
  events: WatchEvents;
}

/** So long a room may take to its first picture; over a slow link it needs a dozen round trips. */
const OPENS_MS = 4000;
/** So long another rendition may take to its first picture. */
const SWITCHES_MS = 2000;

const NOTHING: Receivers = { sound: null, picture: null };

interface Tried {
  room: LiveKitRoom;
  sinceMs: number;
}

/**
 * Watches at one room, and goes to another when that one fails: the old picture stays on the screen
 * until the new one is there.
 */
export class Watch {
  readonly #failover = new Failover();
  #room: LiveKitRoom | null = null;
  #next: Tried | null = null;
  #shown = NOTHING;
  /** The picture that is to come on the screen, and its newest RTP time when it was subscribed. */
  #coming: { receiver: RTCRtpReceiver; rtp: number | undefined } | null = null;
  /** Whose picture was asked for last, and when. */
  #target: { name: string | null; sinceMs: number } = { name: null, sinceMs: 0 };
  #newestRtp: number | undefined;
  #isResting = false;
  #isPlaying = false;

  constructor(private readonly options: WatchOptions) {}

  /** Whether there is a room, be it one that rests. */
  get hasRoom(): boolean {
    return this.#room !== null;
  }

  /** Sets where to watch, or fresh tokens for that; goes there unless a room plays. */
  offer(seats: Seat[], nowMs: number): void {
    this.#failover.offer(seats);
    if (!this.#room && !this.#next) this.#go(nowMs);
  }

  /** Keeps the room but has nothing sent, until `resume`. */
  rest(): void {
    this.#isResting = true;
    this.#next?.room.leave();
    this.#next = null;
    this.#room?.watch(null, false);
    this.#clear();
  }

  /** Has picture and sound sent again; `show` follows, once they are there. */
  resume(nowMs: number): void {
    this.#isResting = false;
    this.#target = { name: null, sinceMs: nowMs };
    this.#failover.begin(nowMs);
  }

  leave(): void {
    this.#room?.leave();
    this.#next?.room.leave();
    this.#room = this.#next = null;
    this.#isResting = false;
    this.#clear();
  }

  /** To be called several times a second. */
  look(nowMs: number): void {
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

  /** The room on the screen is no good; its last picture stays there for now. */
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
    if (this.#next) return; // it has been given up
    const picture = this.#choose(room, nowMs);
    const { sound } = room;
    const isOff = !this.options.wants().picture;
    const isOther = picture !== this.#shown.picture;
    // Until another picture is there the one before stays.
    if (isOther && (isOff || this.#hasCome(picture))) {
      this.#show({ sound, picture });
    } else if (sound !== this.#shown.sound) {
      this.#show({ ...this.#shown, sound });
    }
    const isSwitching = !isOff && picture !== this.#shown.picture;
    const mayStand = isSwitching && nowMs - this.#target.sinceMs < SWITCHES_MS;
    const moves = this.#moves();
    if (moves) this.#play(true);
    if (this.#failover.hasStood(nowMs, moves || mayStand)) this.#break(room, nowMs);
  }

  /** Whether something comes, or need not. */
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

  /** Has the room send what is wanted; returns the picture of it, null while there is none. */
  #choose(room: LiveKitRoom, nowMs: number): RTCRtpReceiver | null {
    const { sound, picture, isSmall } = this.options.wants();
    const names = room.pictures;
    const name = (isSmall || this.options.rendition.isSmall ? names.at(-1) : names[0]) ?? null;
    if (name !== null && name !== this.#target.name) this.#target = { name, sinceMs: nowMs };
    room.watch(picture ? name : null, sound);
    return picture && name !== null ? room.picture(name) : null;
  }

  /** Whether a first frame of this has arrived; receivers are used again, so an old one may be. */
  #hasCome(receiver: RTCRtpReceiver | null): boolean {
    if (receiver === null) return false;
    if (this.#coming?.receiver !== receiver) {
      this.#coming = { receiver, rtp: newestOf(receiver) };
    }
    const rtp = newestOf(receiver);
    return rtp !== undefined && rtp !== this.#coming.rtp;
  }

  /** Nothing of it is on the screen any more. */
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
