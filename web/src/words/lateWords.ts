import { loadSaid } from "./said";

/** What could not be loaded is tried again after so long. */
const AGAIN_MS = 5000;

/** Loads the server's words once, when they are first asked for; again until they are there. */
export class LateWords {
  #asked: Promise<void> | null = null;

  constructor(private readonly load: () => Promise<unknown> = loadSaid) {}

  /** Resolves when they have been loaded, or could not be at first. */
  ask(): Promise<void> {
    this.#asked ??= this.load().then(
      () => {},
      () => {
        setTimeout(() => {
          this.#asked = null;
          void this.ask();
        }, AGAIN_MS);
      },
    );
    return this.#asked;
  }
}
