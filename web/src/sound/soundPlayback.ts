/** Which player plays the sound, the browser's or ours; how ours plays: `soundPlayer.ts`. */

import { look } from "../measure/stats";
import type { Playout } from "../messages";
import { Playback, type PlaybackEvents } from "../playback";
import { t } from "../words/words";
import { BuiltInPlayer, type Heard, lacking, routes } from "./builtInPlayer";
import { levelOfPower } from "./loudness";

/** Which player is to play; "auto" is the built-in one where it can. */
export type PlayerChoice = Playout["player"];

/** Which player plays the sound; `why` it is not the built-in one, null where it is or nobody wanted it. */
export interface SoundPlayerState {
  by: "browser" | "built-in";
  why: string | null;
}

export interface SoundPlaybackEvents extends PlaybackEvents {
  changed(state: SoundPlayerState): void;
  /** A connection is needed whose sound is watched from its beginning. */
  reconnect(): void;
}

/** The browser's player takes over once it has played so much more, and after so long anyway. */
const FILLED_SAMPLES = 4800;
const LOOK_EVERY_MS = 20;
const TAKES_OVER_WITHIN_MS = 1000;
/** After a failure the built-in player is tried again after so long, and each time after twice as long. */
const AGAIN_AFTER_MS = 5000;

/**
 * Plays the sound by the built-in player or by the browser's, and changes from one to the other without
 * a reload: until the built-in one sounds, and once it fails, the browser's plays.
 */
export class SoundPlayback {
  readonly #browser: Playback;
  readonly #builtIn: BuiltInPlayer;
  /** Why the built-in player cannot be used now. */
  #problem = lacking();
  #choice: PlayerChoice = "browser";
  #isPlaying = false;
  /** The built-in player was told to play, and does not sound yet. */
  #isBeginning = false;
  #isTakingOver = false;
  /** The browser's player fills its buffer. */
  #isUnheard = false;
  #isDucked = false;
  #isMuted = false;
  /** As a factor of the amplitude. */
  #loudness = 1;
  #output = "";
  #receiver: RTCRtpReceiver | null = null;
  #state: SoundPlayerState = { by: "browser", why: null };
  #againMs = AGAIN_AFTER_MS;

  constructor(private readonly events: SoundPlaybackEvents) {
    this.#browser = new Playback(events);
    this.#builtIn = new BuiltInPlayer({
      silenced: () => events.silenced?.(),
      resumed: () => events.resumed?.(),
      plays: () => this.#builtInPlays(),
      failed: (why) => this.#builtInFailed(why),
    });
  }

  /** Gets ready for this choice; where that is not possible the browser's player plays. */
  async start(choice: PlayerChoice): Promise<void> {
    if (this.#hindrance() !== null || this.#builtIn.isReady || choice === "browser") return;
    if (!(await this.#builtIn.start())) {
      this.#problem = t("sound.player_not_loaded");
    }
  }

  attach(element: HTMLMediaElement | null): void {
    this.#browser.attach(element);
  }

  /** To be called only at the moment when the receiver is created. */
  watch(receiver: RTCRtpReceiver): void {
    this.#builtIn.watch(receiver);
  }

  /** Sets what a new peer's sound comes by, null for none. */
  take(receiver: RTCRtpReceiver | null): void {
    this.#receiver = receiver;
    this.#browser.take(receiver?.track ?? null);
    this.#update();
  }

  /** Which player is to play, as soon as the connection says how the sound is packed. */
  choose(choice: PlayerChoice, redundancy: number | null): void {
    this.#builtIn.negotiated(redundancy);
    if (choice === this.#choice) return;
    this.#choice = choice;
    const isNew = choice !== "browser" && this.#hindrance() === null && !this.#builtIn.isReady;
    if (!isNew) this.#update();
    else
      void this.start(choice).then(() =>
        this.#builtIn.isReady ? this.events.reconnect() : this.#tell(),
      );
  }

  /** Plays on, but unheard. */
  set isDucked(isDucked: boolean) {
    this.#isDucked = isDucked;
    this.#setLoudness();
  }

  /** Plays on, but unheard, until the viewer wants it otherwise. */
  set isMuted(isMuted: boolean) {
    this.#isMuted = isMuted;
    this.#setLoudness();
  }

  /** From 0 to 1, as ears have it: at the half, it is heard as about half as loud. */
  set volume(volume: number) {
    this.#loudness = volume ** 2;
    this.#setLoudness();
  }

  /**
   * Plays on the device with this id, "" for the browser's own choice. Returns false if there is no
   * such device, and then plays on where the browser would.
   */
  async setOutput(id: string): Promise<boolean> {
    this.#output = id;
    try {
      await Promise.all([this.#browser.setOutput(id), routes() && this.#builtIn.setOutput(id)]);
    } catch {
      if (id === "" || this.#output !== id) return false;
      await this.setOutput("");
      return false;
    }
    this.#update();
    return true;
  }

  #setLoudness(): void {
    const isSilent = this.#isDucked || this.#isMuted;
    this.#builtIn.loudness = isSilent ? 0 : this.#loudness;
    this.#browser.volume = this.#loudness;
    this.#browser.isMuted = isSilent || this.#isUnheard;
  }

  set leastDelayMs(ms: number | null) {
    this.#builtIn.leastDelayMs = ms;
  }

  /** To be called during a touch. */
  play(): void {
    this.#isPlaying = true;
    if (this.#state.by === "browser") this.#browser.play();
    else void this.#builtIn.play();
    this.#update();
  }

  pause(): void {
    this.#isPlaying = false;
    this.#browser.pause();
    this.#rest();
    this.#tell("browser");
  }

  /** What the built-in player sounds now; null while the browser's plays. */
  heard(nowMs: number): Heard | null {
    return this.#state.by === "built-in" ? this.#builtIn.heard(nowMs) : null;
  }

  /**
   * How loud the sound is now, from 0 to 1: of each ear, left first, or of both together, which is
   * all that the browser's player tells. None while nothing plays, or it does not say.
   */
  async levels(): Promise<readonly number[]> {
    if (!this.#isPlaying) return [];
    const levels = this.#state.by === "built-in" ? this.#builtIn.levels : null;
    if (levels) return levels;
    try {
      const level = this.#receiver && (await look(this.#receiver)).inbound.audioLevel;
      return typeof level === "number" ? [levelOfPower(level ** 2)] : [];
    } catch {
      return []; // a peer that was closed meanwhile
    }
  }

  #update(): void {
    const isWanted = this.#choice !== "browser" && this.#hindrance() === null;
    const isBuiltIn = isWanted && this.#builtIn.isReady;
    if (isBuiltIn && this.#isPlaying && this.#state.by === "browser") {
      this.#isBeginning = true;
      void this.#builtIn.play();
    } else if (!isBuiltIn && this.#state.by === "built-in") void this.#takeOver();
    else if (!isBuiltIn && this.#isBeginning) this.#rest();
    this.#tell();
  }

  /** Why the built-in player is not to play. */
  #hindrance(): string | null {
    if (this.#problem !== null) return this.#problem;
    return this.#output !== "" && !routes() ? t("sound.not_routed") : null;
  }

  #rest(): void {
    this.#isBeginning = false;
    this.#builtIn.rest();
  }

  #builtInPlays(): void {
    this.#isBeginning = false;
    this.#browser.pause();
    this.#tell("built-in");
  }

  #builtInFailed(why: string): void {
    this.#isBeginning = false;
    this.#problem = why;
    this.#isUnheard = false;
    this.#setLoudness();
    if (this.#isPlaying) this.#browser.play();
    this.#tell("browser");
    setTimeout(() => {
      this.#problem = null;
      this.#update();
    }, this.#againMs);
    this.#againMs *= 2;
  }

  /** Has the browser's player fill its buffer unheard, then changes to it at once. */
  async #takeOver(): Promise<void> {
    if (this.#isTakingOver) return;
    this.#isTakingOver = true;
    this.#builtIn.share();
    this.#isUnheard = true;
    this.#setLoudness();
    this.#browser.play();
    const untilMs = performance.now() + TAKES_OVER_WITHIN_MS;
    const from = await this.#emitted();
    do {
      await new Promise((resolve) => setTimeout(resolve, LOOK_EVERY_MS));
    } while ((await this.#emitted()) - from < FILLED_SAMPLES && performance.now() < untilMs);
    this.#isTakingOver = false;
    this.#isUnheard = false;
    this.#setLoudness();
    if (this.#state.by === "browser") return; // it failed, or was paused, meanwhile
    this.#builtIn.rest();
    this.#tell("browser");
    this.#update();
  }

  async #emitted(): Promise<number> {
    try {
      const found = this.#receiver && (await look(this.#receiver));
      return found?.inbound.jitterBufferEmittedCount ?? 0;
    } catch {
      return 0; // a peer that was closed meanwhile
    }
  }

  #tell(by = this.#state.by): void {
    const why = by === "built-in" || this.#choice === "browser" ? null : this.#hindrance();
    this.#state = { by, why };
    this.events.changed(this.#state);
  }
}
