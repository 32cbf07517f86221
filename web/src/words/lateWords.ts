import { loadSaid } from "./said";

/** The pause before a failed load is retried. */
const AGAIN_MS = 5000;

/** Loads the server's sentences once, when they are first needed; retries until that succeeds. */
export class LateWords {
  #asked: Promise<void> | null = null;

  constructor(private readonly load: () => Promise<unknown> = loadSaid) {}

  /** Resolves once the first attempt to load them is over. */
  loadOnce(): Promise<void> {
    this.#asked ??= this.load().then(
      () => {},
      () => {
        setTimeout(() => {
          this.#asked = null;
          void this.loadOnce();
        }, AGAIN_MS);
      },
    );
    return this.#asked;
  }
}
