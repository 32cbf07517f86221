/**
 * Plays one stream on one element, and starts again when either is replaced.
 *
 * Picture and sound have separate elements and streams: a common one would apply the browser's own
 * lip synchronisation, and muting one must not pause the other.
 */
export class Playback {
  #element: HTMLMediaElement | null = null;
  #track: MediaStreamTrack | null = null;
  #stream: MediaStream | null = null;
  #playing = false;
  #volume = 1;
  #output = "";

  attach(element: HTMLMediaElement | null): void {
    this.#element = element;
    if (element) element.volume = this.#volume;
    if (this.#output) void this.setOutput(this.#output).catch(() => {});
    this.#show();
  }

  get stream(): MediaStream | null {
    return this.#stream;
  }

  /** Sets the track of a new peer, null for none; one that plays already goes on. */
  take(track: MediaStreamTrack | null): void {
    if (track === this.#track && this.#stream) return;
    this.#track = track;
    this.#stream = track && new MediaStream([track]);
    this.#show();
  }

  /**
   * Plays from now on. Called during a touch, this unlocks the element: iOS then plays later streams
   * on it without another touch.
   */
  play(): void {
    this.#playing = true;
    this.#go();
  }

  /** While muted it plays all the same. */
  set isMuted(isMuted: boolean) {
    if (this.#element) this.#element.muted = isMuted;
  }

  /** From 0 to 1. Browsers of iOS leave that to the buttons of the device. */
  set volume(volume: number) {
    this.#volume = volume;
    if (this.#element) this.#element.volume = volume;
  }

  /** Plays on the device with this id, "" for the browser's own choice; rejects if it is gone. */
  async setOutput(id: string): Promise<void> {
    this.#output = id;
    await this.#element?.setSinkId?.(id);
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
    // After a refusal the element stays paused, and the Start button resolves it.
    this.#element?.play().catch(() => {});
  }
}
