import type { TapeContent } from "../messages";
import { Follower, HEARD, SEEN } from "./follower";
import type { Timeline } from "./timeline";

/** As it was at the robot, or as the operator saw it. */
export type View = "was" | "seen";

/**
 * Plays one part. The picture's element is the clock; its own sound plays in the view `was`. In the
 * view `seen` the sound comes from a separate element, as far behind the picture as it was for the
 * operator. Cameras other than the driving view keep in step with it.
 */
export class Player {
  view: View = "was";
  #rate = 1;
  #hasMedia = false;
  #lengthMs = 0;
  /** When playing started, for parts without picture and sound; null while paused. */
  #startedMs: number | null = null;
  #stoodAtMs = 0;

  readonly #heard: Follower;
  readonly #cameras = new Map<Follower, number>();

  constructor(
    private readonly picture: HTMLVideoElement,
    private readonly sound: HTMLAudioElement,
  ) {
    this.#heard = new Follower(sound, HEARD);
  }

  /** Plays a camera whose pictures began `beganMs` after the part; returns what ends that. */
  attach(camera: HTMLVideoElement, beganMs: number): () => void {
    const follower = new Follower(camera, SEEN);
    this.#cameras.set(follower, beganMs);
    return () => {
      follower.pause();
      this.#cameras.delete(follower);
    };
  }

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

  /** The media's position, in ms since the beginning of the part. */
  get mediaMs(): number {
    if (this.#hasMedia) return this.picture.currentTime * 1000;
    const since = this.#startedMs === null ? 0 : performance.now() - this.#startedMs;
    return Math.min(this.#lengthMs, this.#stoodAtMs + since * this.#rate);
  }

  /** The moment shown: at the robot, or when the operator saw it, a little later. */
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

  /** Keeps sound and cameras in step; call it for each frame of the page. */
  follow(timeline: Timeline): void {
    const runs = this.isPlaying && !this.hasEnded;
    for (const [camera, beganMs] of this.#cameras) {
      if (runs) camera.play(this.mediaMs - beganMs, this.#rate);
      else camera.stand(this.mediaMs - beganMs);
    }
    this.#followWithSound(timeline);
  }

  #followWithSound(timeline: Timeline): void {
    const isApart = this.view === "seen" && this.#hasMedia;
    this.picture.muted = isApart;
    if (!isApart || this.picture.paused) {
      this.#heard.pause();
      return;
    }
    const momentMs = this.momentMs(timeline);
    this.#heard.play(momentMs - timeline.agesAt(momentMs).soundMs, this.#rate);
  }
}
