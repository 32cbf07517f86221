/**
 * Plays one stream on one element, and begins anew when either of them is replaced.
 *
 * Picture and sound have an element and a stream each: one for both would couple them by the
 * browser's own lip synchronisation, and muting one must not pause the other.
 */
export class Playback {
  #element: HTMLMediaElement | null = null;
  #stream: MediaStream | null = null;
  #playing = false;

  attach(element: HTMLMediaElement | null): void {
    this.#element = element;
    this.#show();
  }

  /** The track of a fresh peer, null for none. */
  take(track: MediaStreamTrack | null): void {
    this.#stream = track && new MediaStream([track]);
    this.#show();
  }

  /**
   * Plays from now on. Within a touch this is what unlocks the element: iOS plays later streams
   * on it without another one.
   */
  play(): void {
    this.#playing = true;
    this.#go();
  }

  pause(): void {
    this.#playing = false;
    this.#element?.pause();
  }

  #show(): void {
    if (!this.#element) return;
    this.#element.srcObject = this.#stream;
    if (this.#playing) this.#go();
  }

  #go(): void {
    // A refusal shows itself: the element stands still, and Start is the touch that helps.
    this.#element?.play().catch(() => {});
  }
}
