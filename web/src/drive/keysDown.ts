import { codeOf, type KeyTelling, toldCode, toldKey } from "./codeOf";

/**
 * How long a key without a code counts as held without a repeat or a release, which some on-screen
 * keyboards never send. Systems start to repeat a key sooner.
 */
export const UNHEARD_MS = 2000;

type KeyPress = KeyTelling & Pick<KeyboardEvent, "repeat" | "metaKey">;

interface Down {
  name: string;
  hasCode: boolean;
  timer: ReturnType<typeof setTimeout> | undefined;
}

/**
 * Which keys are down. A release ends the press of the same code, or the same name without codes.
 * As only one of the two events may have a code, it also ends all presses of the other kind; one
 * that matches no press ends all. So as many releases as presses leave nothing held.
 */
export class KeysDown {
  #down = new Map<string, Down>();

  /** `release` is called for each key that is no longer down, but not by `clear`. */
  constructor(private readonly release: (holder: string) => void) {}

  /** The keys that are down, named by `codeOf`. */
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
    // No release comes for an unidentified key, nor on macOS while Meta is down.
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

/** The holder for the key of this event. */
export function holderOf(event: KeyTelling): string {
  return `key ${toldCode(event) || JSON.stringify(toldKey(event).toLowerCase())}`;
}
