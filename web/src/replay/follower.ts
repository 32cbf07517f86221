/** How an element is brought to where it belongs. */
interface Means {
  /** It jumps when it is further away than that, in ms. */
  apartMs: number;
  /** And plays faster or slower by this share when it is further away than `NEAR_MS`. */
  nudge: number;
}

/** Sound jumps soon, and its speed is changed as little as nobody hears. */
export const HEARD: Means = { apartMs: 120, nudge: 0.04 };
/** A picture takes as long to jump as to decode all since its keyframe, so it hurries instead. */
export const SEEN: Means = { apartMs: 1000, nudge: 0.15 };

const NEAR_MS = 15;
/** An element that stands is put where it belongs unless it is nearer. */
const THERE_MS = 1;

/** Holds an element in step with another that is the clock; to be called for each frame. */
export class Follower {
  constructor(
    private readonly element: HTMLMediaElement,
    private readonly means: Means,
  ) {}

  /** Plays at `dueMs` of the element's own time; before its beginning and after its end it waits. */
  play(dueMs: number, rate: number): void {
    const { element, means } = this;
    if (dueMs < 0 || dueMs > element.duration * 1000) {
      this.pause();
      return;
    }
    const lateMs = dueMs - element.currentTime * 1000;
    if (Math.abs(lateMs) > means.apartMs && !element.seeking) element.currentTime = dueMs / 1000;
    const nudge = Math.abs(lateMs) > NEAR_MS ? Math.sign(lateMs) * means.nudge : 0;
    element.playbackRate = rate * (1 + nudge);
    // Whoever plays at the end begins anew.
    if (element.paused && !element.ended) void element.play().catch(() => {});
  }

  /** Stands at `dueMs`, or where it is nearest to that. */
  stand(dueMs: number): void {
    this.pause();
    const { element } = this;
    const endMs = Number.isNaN(element.duration) ? Infinity : element.duration * 1000;
    const atMs = Math.min(Math.max(0, dueMs), endMs);
    if (Math.abs(atMs - element.currentTime * 1000) > THERE_MS && !element.seeking) {
      element.currentTime = atMs / 1000;
    }
  }

  pause(): void {
    if (!this.element.paused) this.element.pause();
  }
}
