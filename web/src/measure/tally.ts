/**
 * How much counters rise while a stream is on. Browsers keep counting when nothing is sent, so that
 * the time in which a stream was off would look like one long concealment or freeze.
 */
export class Tally<Name extends string> {
  /** The sums for this peer. */
  readonly total: Readonly<Record<Name, number>>;
  readonly #names: readonly Name[];
  #last: Readonly<Record<Name, number>> | null = null;
  #idleAt: number | null = 0;

  constructor(...names: Name[]) {
    this.#names = names;
    this.total = this.#each(() => 0);
  }

  /** Pauses counting while the stream is off; it resumes when something arrives. */
  rest(): void {
    this.#last = null;
    this.#idleAt = null;
  }

  /**
   * Adds a sample of the counters; returns how much they have risen since the previous one. `come`
   * is the count of packets or pictures received.
   */
  add(come: number, counts: Readonly<Record<Name, number>>): Readonly<Record<Name, number>> {
    const last = this.#last;
    if (!last) {
      this.#idleAt ??= come;
      if (come > this.#idleAt) this.#last = counts;
      return this.#each(() => 0);
    }
    this.#last = counts;
    const risen = this.#each((name) => Math.max(0, counts[name] - last[name]));
    Object.assign(
      this.total,
      this.#each((name) => this.total[name] + risen[name]),
    );
    return risen;
  }

  #each(value: (name: Name) => number): Record<Name, number> {
    return Object.fromEntries(this.#names.map((name) => [name, value(name)])) as Record<
      Name,
      number
    >;
  }
}
