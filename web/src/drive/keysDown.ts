import { codeOf, type KeyTelling, toldCode, toldKey } from "./codeOf";

/**
 * For so long a key without a code counts as held when neither a repeat nor a release comes, which
 * some on-screen keyboards never send. Systems wait for less before they repeat a key.
 */
export const UNHEARD_MS = 2000;

type KeyPress = KeyTelling & Pick<KeyboardEvent, "repeat" | "metaKey">;

interface Down {
  name: string;
  hasCode: boolean;
  timer: ReturnType<typeof setTimeout> | undefined;
}

/**
 * Which keys are down. A release counts for the press of the same code, or of the same name where
 * neither has a code. Whatever else it may be of is let go, too: all of the other kind, and all at
 * all where it is of nothing that is known. So as many releases as presses leave nothing held.
 */
export class KeysDown {
  #down = new Map<string, Down>();

  /** `release` is called for each key that is no longer down, but not by `clear`. */
  constructor(private readonly release: (holder: string) => void) {}

  /** The keys that are down, as `codeOf` says them. */
  get names(): string[] {
    return [...this.#down.values()].map(({ name }) => name);
  }

  has(event: KeyTelling): boolean {
    return this.#down.has(holderOf(event));
  }

  /** Handles a keydown; returns whether it is a new press: not every browser marks all repeats. */
  press(event: KeyPress): boolean {
    const [holder, name] = [holderOf(event), codeOf(event)];
    const isNew = !(event.repeat || this.#down.has(holder));
    // Of what tells nothing, and on macOS while Meta is down, no release can be waited for.
    if (name === "" || event.metaKey) return isNew;
    clearTimeout(this.#down.get(holder)?.timer);
    const hasCode = toldCode(event) !== "";
    const timer = hasCode ? undefined : setTimeout(() => this.#drop(holder), UNHEARD_MS);
    this.#down.set(holder, { name, hasCode, timer });
    return isNew;
  }

  /** Handles a keyup. */
  lift(event: KeyTelling): void {
    const [lifted, hasCode] = [holderOf(event), toldCode(event) !== ""];
    const isKnown = this.#down.has(lifted);
    for (const [holder, key] of [...this.#down]) {
      if (!isKnown || holder === lifted || key.hasCode !== hasCode) this.#drop(holder);
    }
  }

  clear(): void {
    for (const { timer } of this.#down.values()) clearTimeout(timer);
    this.#down.clear();
  }

  #drop(holder: string): void {
    clearTimeout(this.#down.get(holder)?.timer);
    this.#down.delete(holder);
    this.release(holder);
  }
}

/** Who holds what this key holds, by what its event tells. */
export function holderOf(event: KeyTelling): string {
  return `key ${toldCode(event) || JSON.stringify(toldKey(event).toLowerCase())}`;
}
