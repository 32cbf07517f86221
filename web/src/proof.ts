/** Starts and polls the proof of the stop; its view: `view/ProofPanel.tsx`. */

import { ask, post } from "./link/http";
import type { Answers } from "./messages";

export type Proof = Answers["api/proof"];

export interface ProverOptions {
  tell: (proof: Proof) => void;
  /** Shows an error to the user. */
  complain: (sentence: string) => void;
}

const PATH = "api/proof";
const LOOK_EVERY_MS = 1000;

/** Starts and polls the proof of the stop, on the host's page. */
export class Prover {
  #timer: ReturnType<typeof setTimeout> | undefined;
  #isRunning = false;

  constructor(private readonly options: ProverOptions) {}

  /** Starts a proof; the user has confirmed that the wheels are off the floor. */
  async start(): Promise<void> {
    await this.#tell(() => post(PATH, { lifted: true }));
  }

  /** Fetches the progress, and again every second while it runs. */
  async poll(): Promise<void> {
    await this.#tell(() => ask(PATH));
  }

  async #tell(request: () => Promise<Proof>): Promise<void> {
    clearTimeout(this.#timer);
    try {
      const proof = await request();
      this.#isRunning = proof.state === "running";
      this.options.tell(proof);
    } catch (error) {
      this.options.complain(error instanceof Error ? error.message : String(error));
    }
    clearTimeout(this.#timer);
    // A server that is busy with a proof may fail to answer; the proof continues.
    if (!this.#isRunning) return;
    this.#timer = setTimeout(() => void this.poll(), LOOK_EVERY_MS);
  }
}
