/** When the voice is sent and the robot's sound is muted; who may speak: `../permissions.ts`. */

import { Unsettled, within } from "../within";
import { pageSentence, type Saying, says } from "../words/said";
import { ENCODINGS, EncodingChooser, type Uplink, type VoiceEncoding } from "./encoding";
import { Microphone } from "./microphone";

/** What the page shows of this user's voice. */
export interface Voice {
  /** The microphone is on, and its sound is sent. */
  isOn: boolean;
  /** The microphone is being opened; the user may have to allow it. */
  isOpening: boolean;
  /** It stays on without being held. */
  isKept: boolean;
  /** From 0 to 1; 0 while it is off. */
  level: number;
  /** The server says that the robot plays the voice. */
  isHeard: boolean;
  /** Why the voice is not heard. */
  problem: Saying | null;
}

export const SILENT: Voice = {
  isOn: false,
  isOpening: false,
  isKept: false,
  level: 0,
  isHeard: false,
  problem: null,
};

/** The connection, as far as a voice needs it. */
export interface VoiceLink {
  speak(track: MediaStreamTrack | null): Promise<void>;
  shape(encoding: VoiceEncoding): void;
}

export interface TalkOptions {
  /** The connection now; null where there is none. */
  link: () => VoiceLink | null;
  uplink: () => Uplink;
  changed: (voice: Voice) => void;
  /** The age of the robot's sound on this page. */
  soundMs: () => number;
  /** Mutes the robot's sound, so that the user does not hear their own echo. */
  duck: (isDucked: boolean) => void;
  open?: typeof Microphone.open;
}

const LOOK_EVERY_MS = 100;
/** A level above this, 36 dB below full scale, is speech, even before the robot plays it. */
const SPEAKS_LEVEL = 0.4;
/** How long the microphone stays open after its last use, since opening it takes a moment. */
const KEPT_OPEN_MS = 30_000;
/** The echo by the robot's microphone has passed after a time within these bounds. */
const ECHO_MS = { least: 500, most: 2500 } as const;

/**
 * Sends the microphone's sound while it is held, by a finger or a key, or kept open. Otherwise
 * nothing of it reaches the link, and the device is released half a minute later.
 */
export class Talk {
  #voice = SILENT;
  #isAllowed = false;
  readonly #holders = new Set<string>();
  #microphone: Microphone | null = null;
  #opening: Promise<void> | null = null;
  readonly #chooser = new EncodingChooser();
  #encoding: VoiceEncoding | null = ENCODINGS[0] ?? null;
  #isDucked = false;
  /** Whether the voice's problem is that the link has no room for it. */
  #isCramped = false;
  #sent: { link: VoiceLink; track: MediaStreamTrack | null } | null = null;
  #looking: ReturnType<typeof setInterval> | undefined;
  #closing: ReturnType<typeof setTimeout> | undefined;
  #echo: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly options: TalkOptions) {}

  /** Sets whether this user may speak; without permission the voice ends at once. */
  allow(isAllowed: boolean): void {
    this.#isAllowed = isAllowed;
    if (!isAllowed) this.letGo(true);
  }

  /** Speaks while any holder holds it. */
  press(holder: string): void {
    if (!this.#isAllowed) return;
    this.#holders.add(holder);
    this.#update();
  }

  /** Returns false if this holder did not hold it. */
  release(holder: string): boolean {
    const was = this.#holders.delete(holder);
    if (was) this.#update();
    return was;
  }

  /** Keeps the microphone open without being held, or stops that. */
  keepOpen(isKept: boolean): void {
    if (!this.#isAllowed) return;
    this.#tell({ isKept });
    this.#update();
  }

  /** Releases all that is held; with `entirely` also an open microphone. */
  letGo(entirely = false): void {
    this.#holders.clear();
    if (entirely) this.#tell({ isKept: false });
    this.#update();
  }

  /** Handles the server's report on whether the voice is heard. */
  reported(isHeard: boolean, reason: Saying | null): void {
    this.#tell({ isHeard, ...(this.#voice.isOn ? { problem: reason } : {}) });
  }

  /** Sends the voice over a new connection. */
  reconnected(): void {
    this.#sent = null;
    this.#update();
  }

  /** Adapts the encoding to the link; call it a few times a second, even without a voice. */
  adapt(nowMs: number): void {
    this.#encoding = this.#chooser.next(this.options.uplink(), this.#voice.isOn, nowMs);
    if (this.#voice.isOn) this.#send();
  }

  get #isWanted(): boolean {
    return this.#isAllowed && (this.#holders.size > 0 || this.#voice.isKept);
  }

  #update(): void {
    if (this.#isWanted && !this.#microphone) {
      this.#opening ??= this.#open();
      return;
    }
    const isOn = this.#isWanted;
    const changes = isOn !== this.#voice.isOn;
    if (changes) this.#tell(isOn ? { isOn, problem: null } : { isOn, level: 0, isHeard: false });
    this.#send();
    this.#duck();
    if (!changes) return;
    clearInterval(this.#looking);
    clearTimeout(this.#closing);
    if (isOn) this.#looking = setInterval(() => this.#measure(), LOOK_EVERY_MS);
    else this.#closing = setTimeout(() => this.#close(), KEPT_OPEN_MS);
  }

  async #open(): Promise<void> {
    this.#tell({ isOpening: true, problem: null });
    try {
      const open = this.options.open ?? Microphone.open;
      const opening = open((sentence) => this.#gone(sentence));
      // The user may still be reading the browser's question, so this only says what is awaited.
      within("getUserMedia", opening).catch((error) => {
        if (error instanceof Unsettled) this.#tell({ problem: error.saying });
      });
      this.#microphone = await opening;
      this.#tell({ problem: null });
    } catch (error) {
      this.#holders.clear();
      this.#tell({ isKept: false, problem: error instanceof Error ? says(error.message) : null });
    }
    this.#opening = null;
    this.#tell({ isOpening: false });
    // It may have been released, or forbidden, while the user was asked.
    this.#update();
    if (this.#microphone && !this.#voice.isOn) {
      clearTimeout(this.#closing);
      this.#closing = setTimeout(() => this.#close(), KEPT_OPEN_MS);
    }
  }

  #gone(sentence: string): void {
    this.letGo(true);
    this.#close();
    this.#tell({ problem: says(sentence) });
  }

  #close(): void {
    clearTimeout(this.#closing);
    this.#microphone?.close();
    this.#microphone = null;
  }

  #measure(): void {
    this.#tell({ level: this.#encoding ? (this.#microphone?.level ?? 0) : 0 });
  }

  /** Sends the voice over the connection, or nothing where there is no room for it. */
  #send(): void {
    const link = this.options.link();
    if (!link) return;
    const { isOn } = this.#voice;
    if (isOn && this.#encoding) link.shape(this.#encoding);
    const hasRoom = this.#encoding !== null;
    if (isOn && !hasRoom) {
      this.#tell({ problem: pageSentence("voice.no_room"), isHeard: false });
      this.#isCramped = true;
    } else if (this.#isCramped) {
      this.#tell({ problem: null });
      this.#isCramped = false;
    }
    const track = isOn && hasRoom ? (this.#microphone?.track ?? null) : null;
    if (this.#sent?.link === link && this.#sent.track === track) return;
    if (this.#sent === null && track === null) return;
    this.#sent = { link, track };
    // If the connection has ended meanwhile, `reconnected` sends over the next one.
    link.speak(track).catch(() => {});
  }

  /**
   * Mutes the robot's sound while the voice could come back as an echo. With an open microphone
   * that is only while the user speaks or the robot plays it, and until the echo has passed.
   */
  #duck(): void {
    const { isOn, isHeard, level, problem } = this.#voice;
    const isSpeaking = this.#holders.size > 0 || isHeard || level >= SPEAKS_LEVEL;
    const isDucked = isOn && problem === null && isSpeaking;
    if (isDucked === this.#isDucked) return;
    this.#isDucked = isDucked;
    clearTimeout(this.#echo);
    if (isDucked) {
      this.options.duck(true);
      return;
    }
    const echoMs = 2 * (this.options.soundMs() + (this.options.uplink().roundTripMs ?? 0));
    const waitMs = Math.max(ECHO_MS.least, Math.min(echoMs, ECHO_MS.most));
    this.#echo = setTimeout(() => this.options.duck(false), waitMs);
  }

  #tell(change: Partial<Voice>): void {
    const now = { ...this.#voice, ...change };
    const keys = Object.keys(change) as (keyof Voice)[];
    if (keys.every((key) => this.#voice[key] === now[key])) return;
    this.#voice = now;
    this.options.changed(now);
    this.#duck();
  }
}
