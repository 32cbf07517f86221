/** Which size of the driving view this page asks for: no more than it can show. */

import { isFullscreen, watchFullscreen } from "./fullscreen";
import type { State } from "./state";

/** Nobody sees more of a screen's pixels for each pixel of CSS. */
const MOST_DENSITY = 2;
/** A larger size is asked for when the one in force is enlarged by more than this: hysteresis. */
const KEPT_UNTIL = 1.2;
/** A smaller size is asked for when it has been enough for this long. */
const SETTLED_MS = 2000;
/** A larger picture comes within this time, or the link does not carry it. */
const COMES_WITHIN_MS = 3000;

export interface Box {
  width: number;
  height: number;
}

/** By how much a picture of this size, as `640x480`, is enlarged to fill the box. */
export function enlargement(size: string, { width, height }: Box): number {
  const [across = Number.NaN, down = Number.NaN] = size.split("x").map(Number);
  return Math.min(width / across, height / down);
}

/** The smallest size that need not be enlarged; `sizes` begin with the largest. Pure. */
export function enough(sizes: readonly string[], box: Box, inForce: string | null) {
  const fills = (one: string) => enlargement(one, box) <= (one === inForce ? KEPT_UNTIL : 1);
  return sizes.findLast(fills) ?? sizes[0];
}

interface IPhoneVideo {
  webkitDisplayingFullscreen?: boolean;
}

type Options = Pick<State, "hello" | "preferences" | "box" | "size"> & {
  /** Called when another size is to be asked for. */
  changed: () => void;
};

/**
 * A larger size is asked for at once, a smaller one when resizing is over, since each change costs
 * a keyframe. In fullscreen and for a photo it is the largest that the user allows.
 */
export class WantedSize {
  #video: (HTMLVideoElement & IPhoneVideo) | null = null;
  #isForPhoto = false;
  #settling: ReturnType<typeof setTimeout> | undefined;
  readonly #observer = new ResizeObserver(([entry]) => {
    const { width, height } = entry?.contentRect ?? { width: 0, height: 0 };
    if (width * height === 0) return;
    this.options.box.value = { width, height };
    this.#follow();
  });
  readonly #follow = () => {
    const { hello, size, changed } = this.options;
    clearTimeout(this.#settling);
    const [now, next] = [size.peek(), this.#next()];
    if (now === null || next === undefined || next === now) return;
    const sizes = hello.peek()?.sizes ?? [];
    if (sizes.indexOf(next) < sizes.indexOf(now)) changed();
    else this.#settling = setTimeout(changed, SETTLED_MS);
  };

  constructor(private readonly options: Options) {
    watchFullscreen(this.#follow);
  }

  /** Watches this element's size; null for none. */
  attach(video: HTMLVideoElement | null): void {
    this.#observer.disconnect();
    this.#video = video;
    if (!video) return;
    this.#observer.observe(video);
    video.addEventListener("webkitbeginfullscreen", this.#follow);
    video.addEventListener("webkitendfullscreen", this.#follow);
  }

  /** The size to ask for, which is in force from now on; undefined before the greeting. */
  choose(): string | undefined {
    clearTimeout(this.#settling);
    const next = this.#next();
    this.options.size.value = next ?? null;
    return next;
  }

  /** Calls `take` once the largest picture has come, unless the link does not carry it. */
  async forPhoto<Taken>(take: () => Promise<Taken>): Promise<Taken> {
    const before = this.options.size.peek();
    this.#isForPhoto = true;
    this.#follow();
    try {
      if (this.options.size.peek() !== before) await this.#comes();
      return await take();
    } finally {
      this.#isForPhoto = false;
      this.#follow();
    }
  }

  #comes(): Promise<unknown> {
    return new Promise((resolve) => {
      this.#video?.addEventListener("resize", resolve, { once: true });
      setTimeout(resolve, COMES_WITHIN_MS);
    });
  }

  #next(): string | undefined {
    const { hello, preferences, box, size } = this.options;
    const sizes = hello.peek()?.sizes ?? [];
    const allowed = sizes.slice(Math.max(0, sizes.indexOf(preferences.peek().size)));
    const shown = box.peek();
    const isFull = this.#isForPhoto || isFullscreen() || this.#video?.webkitDisplayingFullscreen;
    if (isFull || !shown) return allowed[0];
    const density = Math.min(window.devicePixelRatio, MOST_DENSITY);
    const seen = { width: shown.width * density, height: shown.height * density };
    return enough(allowed, seen, size.peek());
  }
}
