/** How an element is brought into step. */
interface Means {
  /** It seeks when it is off by more than this, in ms. */
  apartMs: number;
  /** It plays faster or slower by this share when it is off by more than `NEAR_MS`. */
  nudge: number;
}

/** Sound seeks soon, and its speed changes too little to be heard. */
export const HEARD: Means = { apartMs: 120, nudge: 0.04 };
/** Seeking a picture means decoding everything since its keyframe, so it speeds up instead. */
export const SEEN: Means = { apartMs: 1000, nudge: 0.15 };

const NEAR_MS = 15;
/** A paused element is moved if it is off by more than this. */
const THERE_MS = 1;

/** Keeps an element in step with another one, the clock; call it for each frame. */
export class Follower {
  constructor(
    private readonly element: HTMLMediaElement,
    private readonly means: Means,
  ) {}

  /** Plays at `dueMs` of the element's own time; pauses before its beginning and after its end. */
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
    // At its end, `play` would start over.
    if (element.paused && !element.ended) void element.play().catch(() => {});
  }

  /** Pauses at `dueMs`, or as near to it as possible. */
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
