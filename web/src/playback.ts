/** How often a muted element is restarted while the system keeps pausing it. */
const AGAIN_EVERY_MS = 1000;

export interface PlaybackEvents {
  /** Playing has stopped: the system paused it, as for a phone call, or demands a touch first. */
  silenced?(): void;
  /** The system has resumed it. */
  resumed?(): void;
}

/**
 * Plays one stream on one element, and restarts when either is replaced.
 *
 * Picture and sound have separate elements and streams: a common one would apply the browser's own
 * lip synchronisation, and muting one must not pause the other.
 */
export class Playback {
  #element: HTMLMediaElement | null = null;
  #track: MediaStreamTrack | null = null;
  #stream: MediaStream | null = null;
  #playing = false;
  #isSilenced = false;
  #volume = 1;
  #output = "";
  #watching = new AbortController();

  constructor(private readonly events: PlaybackEvents = {}) {}

  attach(element: HTMLMediaElement | null): void {
    this.#watching.abort();
    this.#watching = new AbortController();
    const { signal } = this.#watching;
    this.#element = element;
    for (const type of ["pause", "play"]) {
      element?.addEventListener(type, () => this.#noticed(element), { signal });
    }
    if (element) element.volume = this.#volume;
    if (this.#output) void this.setOutput(this.#output).catch(() => {});
    this.#show();
  }

  get stream(): MediaStream | null {
    return this.#stream;
  }

  /** Sets the track of a new peer, null for none; a track that already plays continues. */
  setTrack(track: MediaStreamTrack | null): void {
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
    this.#isSilenced = false;
    this.#go();
  }

  /** A muted element keeps playing. */
  set isMuted(isMuted: boolean) {
    if (this.#element) this.#element.muted = isMuted;
  }

  /** From 0 to 1. On iOS only the device's buttons change it. */
  set volume(volume: number) {
    this.#volume = volume;
    if (this.#element) this.#element.volume = volume;
  }

  /** Plays on the device with this id, "" for the browser's default; rejects if it is gone. */
  async setOutput(id: string): Promise<void> {
    this.#output = id;
    await this.#element?.setSinkId?.(id);
  }

  pause(): void {
    this.#playing = false;
    this.#isSilenced = false;
    this.#element?.pause();
  }

  #show(): void {
    if (!this.#element) return;
    this.#element.srcObject = this.#stream;
    if (this.#playing) this.#go();
  }

  #go(): void {
    this.#element?.play().catch((error: unknown) => {
      if (error instanceof DOMException && error.name === "NotAllowedError") this.#silence();
    });
  }

  /** Handles the element's `pause` and `play`, perhaps by the system. */
  #noticed(element: HTMLMediaElement): void {
    const { paused, ended, muted } = element;
    if (!this.#playing || ended || element !== this.#element) return;
    if (!paused && this.#isSilenced) {
      this.#isSilenced = false;
      this.events.resumed?.();
    } else if (paused && muted) {
      this.#go();
      setTimeout(() => this.#noticed(element), AGAIN_EVERY_MS);
    } else if (paused) this.#silence();
  }

  /** Does not pause the element: after a call WebKit resumes only what the page did not pause. */
  #silence(): void {
    if (!this.#playing || this.#isSilenced) return;
    this.#isSilenced = true;
    this.events.silenced?.();
  }
}
