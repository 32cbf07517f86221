import { type Answer, ask, post } from "./link/http";

/** How far the proof of the stop is; `line` says what it does now, `record` is a path. */
export interface Proof {
  state: "never" | "running" | "done" | "failed";
  line: string;
  record: string | null;
}

export interface ProverOptions {
  tell: (proof: Proof) => void;
  /** A sentence for a person. */
  complain: (sentence: string) => void;
}

const PATH = "/api/proof";
const LOOK_EVERY_MS = 1000;

/** Starts the proof of the stop, and follows it while it runs. For pages of the host. */
export class Prover {
  #timer: ReturnType<typeof setTimeout> | undefined;
  #isRunning = false;

  constructor(private readonly options: ProverOptions) {}

  /** Starts a proof; the wheels are off the floor. */
  async start(): Promise<void> {
    await this.#tell(() => post(PATH, { lifted: true }));
  }

  /** Looks how far it is, and again each second while it runs. */
  async look(): Promise<void> {
    await this.#tell(() => ask(PATH));
  }

  async #tell(request: () => Promise<Answer>): Promise<void> {
    clearTimeout(this.#timer);
    try {
      const proof = (await request()) as unknown as Proof;
      this.#isRunning = proof.state === "running";
      this.options.tell(proof);
    } catch (error) {
      this.options.complain(error instanceof Error ? error.message : String(error));
    }
    clearTimeout(this.#timer);
    // A server that is busy with a proof may miss to answer; the proof goes on.
    if (!this.#isRunning) return;
    this.#timer = setTimeout(() => void this.look(), LOOK_EVERY_MS);
  }
}
