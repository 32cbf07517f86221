import { loadSaid } from "./said";

/** What could not be loaded is tried again after so long. */
const AGAIN_MS = 5000;

/** Loads the server's words once, when they are first asked for; again until they are there. */
export class LateWords {
  #isAsked = false;

  constructor(private readonly load: () => Promise<unknown> = loadSaid) {}

  ask(): void {
    if (this.#isAsked) return;
    this.#isAsked = true;
    this.load().catch(() => {
      setTimeout(() => {
        this.#isAsked = false;
        this.ask();
      }, AGAIN_MS);
    });
  }
}
