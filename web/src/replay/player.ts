import type { TapeContent } from "../messages";
import type { Timeline } from "./timeline";

/** As it was at the robot, or as it came to the operator. */
export type View = "was" | "seen";

/** The sound is put where it belongs when it is further away than that, in ms. */
const APART_MS = 120;
/** And played a little faster or slower when it is further away than that. */
const NEAR_MS = 15;
const NUDGE = 0.04;

/**
 * Plays one part. The picture's element is the clock; its own sound is heard where the view is as
 * it was. As the operator saw it, the sound comes from an element of its own, which is held as far
 * behind the picture as it was for them.
 */
export class Player {
  view: View = "was";
  #rate = 1;
  #hasMedia = false;
  #lengthMs = 0;
  /** Without picture and sound time still passes; since when, null while it stands. */
  #startedMs: number | null = null;
  #stoodAtMs = 0;

  constructor(
    private readonly picture: HTMLVideoElement,
    private readonly sound: HTMLAudioElement,
  ) {}

  load(content: TapeContent): void {
    this.pause();
    this.#hasMedia = content.has_media;
    this.#lengthMs = content.length_ms;
    this.#stoodAtMs = 0;
    const url = `media/${encodeURIComponent(content.name)}`;
    for (const one of [this.picture, this.sound]) {
      if (content.has_media) one.src = url;
      else one.removeAttribute("src");
      one.load();
    }
    this.rate = this.#rate;
  }

  get isPlaying(): boolean {
    return this.#hasMedia ? !this.picture.paused : this.#startedMs !== null;
  }

  get hasEnded(): boolean {
    return this.#hasMedia ? this.picture.ended : this.mediaMs >= this.#lengthMs;
  }

  get rate(): number {
    return this.#rate;
  }

  set rate(rate: number) {
    this.#stoodAtMs = this.mediaMs;
    if (this.#startedMs !== null) this.#startedMs = performance.now();
    this.#rate = rate;
    this.picture.playbackRate = this.sound.playbackRate = rate;
  }

  /** Where picture and sound are, in ms since the beginning of the part. */
  get mediaMs(): number {
    if (this.#hasMedia) return this.picture.currentTime * 1000;
    const since = this.#startedMs === null ? 0 : performance.now() - this.#startedMs;
    return Math.min(this.#lengthMs, this.#stoodAtMs + since * this.#rate);
  }

  /** The moment that is shown: of the robot, or of the operator who sees it a little later. */
  momentMs(timeline: Timeline): number {
    return this.view === "was" ? this.mediaMs : timeline.whenSeen(this.mediaMs, "pictureMs");
  }

  seek(momentMs: number, timeline: Timeline): void {
    const ageMs = this.view === "was" ? 0 : timeline.agesAt(momentMs).pictureMs;
    const mediaMs = Math.max(0, momentMs - ageMs);
    if (this.#hasMedia) {
      this.picture.currentTime = mediaMs / 1000;
    } else {
      this.#stoodAtMs = mediaMs;
      if (this.#startedMs !== null) this.#startedMs = performance.now();
    }
    this.follow(timeline);
  }

  async play(): Promise<void> {
    if (this.#hasMedia) await this.picture.play();
    else this.#startedMs ??= performance.now();
  }

  pause(): void {
    this.#stoodAtMs = this.mediaMs;
    this.#startedMs = null;
    this.picture.pause();
    this.sound.pause();
  }

  /** Holds the sound where it belongs; to be called for each frame of the page. */
  follow(timeline: Timeline): void {
    const isApart = this.view === "seen" && this.#hasMedia;
    this.picture.muted = isApart;
    if (!isApart || this.picture.paused) {
      if (!this.sound.paused) this.sound.pause();
      return;
    }
    const momentMs = this.momentMs(timeline);
    const dueMs = momentMs - timeline.agesAt(momentMs).soundMs;
    if (dueMs < 0) return;
    const lateMs = dueMs - this.sound.currentTime * 1000;
    if (Math.abs(lateMs) > APART_MS) this.sound.currentTime = dueMs / 1000;
    const nudge = Math.abs(lateMs) > NEAR_MS ? Math.sign(lateMs) * NUDGE : 0;
    this.sound.playbackRate = this.#rate * (1 + nudge);
    if (this.sound.paused) void this.sound.play().catch(() => {});
  }
}
