/** Which player plays the sound, the browser's or ours; how ours plays: `soundPlayer.ts`. */

import { readStats } from "../measure/stats";
import type { Playout } from "../messages";
import { Playback, type PlaybackEvents } from "../playback";
import { t } from "../words/words";
import { BuiltInPlayer, type Heard, lacking, routes } from "./builtInPlayer";
import { levelOfPower } from "./loudness";

/** Which player should play; "auto" is the built-in one where possible. */
export type PlayerChoice = Playout["player"];

/** Which player plays, and `why` the built-in one does not; null if it does or was not chosen. */
export interface SoundPlayerState {
  by: "browser" | "built-in";
  why: string | null;
}

export interface SoundPlaybackEvents extends PlaybackEvents {
  changed(state: SoundPlayerState): void;
  /** Connect anew: the sound must be watched from its beginning. */
  reconnect(): void;
}

/** The browser's player takes over once it has buffered this much, or after this time. */
const FILLED_SAMPLES = 4800;
const LOOK_EVERY_MS = 20;
const TAKES_OVER_WITHIN_MS = 1000;
/** The pause before the built-in player is retried after a failure; it doubles each time. */
const AGAIN_AFTER_MS = 5000;

/**
 * Plays the sound by the built-in player or the browser's, and switches between them without a
 * reload: the browser's plays until the built-in one starts, and after it fails.
 */
export class SoundPlayback {
  readonly #browser: Playback;
  readonly #builtIn: BuiltInPlayer;
  /** Why the built-in player cannot be used now. */
  #problem = lacking();
  #choice: PlayerChoice = "browser";
  #isPlaying = false;
  /** Whether the built-in player is starting and not heard yet. */
  #isBeginning = false;
  #isTakingOver = false;
  /** Whether the browser's player is muted while it fills its buffer. */
  #isUnheard = false;
  #isDucked = false;
  #isMuted = false;
  /** A factor of the amplitude. */
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

  /** Prepares for this choice; if that fails, the browser's player plays. */
  async start(choice: PlayerChoice): Promise<void> {
    if (this.#hindrance() !== null || this.#builtIn.isReady || choice === "browser") return;
    if (!(await this.#builtIn.start())) {
      this.#problem = t("sound.player_not_loaded");
    }
  }

  attach(element: HTMLMediaElement | null): void {
    this.#browser.attach(element);
  }

  /** Watches a receiver; call it only when it has just been created. */
  watch(receiver: RTCRtpReceiver): void {
    this.#builtIn.watch(receiver);
  }

  /** Sets the receiver of a new peer's sound; null for none. */
  setReceiver(receiver: RTCRtpReceiver | null): void {
    this.#receiver = receiver;
    this.#browser.setTrack(receiver?.track ?? null);
    this.#update();
  }

  /** Chooses the player; called once the connection's `redundancy` payload type is known. */
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

  /** Silences the sound while the user speaks; it plays on. */
  set isDucked(isDucked: boolean) {
    this.#isDucked = isDucked;
    this.#setLoudness();
  }

  /** Mutes the sound at the user's wish; it plays on. */
  set isMuted(isMuted: boolean) {
    this.#isMuted = isMuted;
    this.#setLoudness();
  }

  /** From 0 to 1, perceptual: 0.5 sounds about half as loud. */
  set volume(volume: number) {
    this.#loudness = volume ** 2;
    this.#setLoudness();
  }

  /**
   * Plays on the device with this id, "" for the browser's default. Returns false if there is no
   * such device, and then plays on the default.
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

  /** Starts the sound; call it during a touch. */
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

  /** What the built-in player plays now; null while the browser's plays. */
  heard(nowMs: number): Heard | null {
    return this.#state.by === "built-in" ? this.#builtIn.heard(nowMs) : null;
  }

  /**
   * The sound's level now, from 0 to 1: per ear, left first, or of both together, which is all that
   * the browser's player reports. Empty while nothing plays or the level is unknown.
   */
  async levels(): Promise<readonly number[]> {
    if (!this.#isPlaying) return [];
    const levels = this.#state.by === "built-in" ? this.#builtIn.levels : null;
    if (levels) return levels;
    try {
      const level = this.#receiver && (await readStats(this.#receiver)).inbound.audioLevel;
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

  /** Why the built-in player cannot play now; null if it can. */
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

  /** Lets the browser's player fill its buffer unheard, then switches to it at once. */
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
    if (this.#state.by === "browser") return; // the built-in player failed or was paused meanwhile
    this.#builtIn.rest();
    this.#tell("browser");
    this.#update();
  }

  async #emitted(): Promise<number> {
    try {
      const found = this.#receiver && (await readStats(this.#receiver));
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
