/** When what is held and set of the robot's controls is sent; what that is: `operating.ts`. */

import type { Operate, Operated, Sentence } from "../messages";

export interface OperateSenderOptions {
  /** What is held now, by the controls' names. */
  held: () => Record<string, number>;
  /** The turn's number while this page drives, else 0. */
  turn: () => number;
  /** The time on the server's clock, null while the clocks are not aligned. */
  serverMs: () => number | null;
  /** The newest beat heard from the server, null before the first. */
  beat: () => string | null;
  send: (operate: Operate, urgent: boolean) => void;
  /** Called when the page hung and has yet to process the input of that time. */
  hung: () => void;
  /** Called whenever `wanted` changes. */
  wants: (wanted: Readonly<Record<string, number>>) => void;
  /** Something has no effect: why, or null if it did not arrive. */
  refused: (why: Sentence | null) => void;
}

interface Wish {
  value: number;
  sinceMs: number;
  /** When the server took it; it is shown until the room says so, too. */
  takenMs: number | null;
}

/** As often as a set-point at its slowest: what is held counts no longer than one. */
const EVERY_MS = 50;
/** What is set is repeated no more often than the server takes it. */
const WISHES_EVERY_MS = 110;
const MOST_WISHES = 2;
/** As for a set-point, since the channel may lose any of them. */
const AGAIN_AFTER_MS = [45, 90] as const;
/** A wish that has not arrived by then is given up, so that it comes true at no odd time. */
const GIVE_UP_MS = 3000;
/** The room tells of it within so long. */
const TOLD_WITHIN_MS = 1500;
const HUNG_MS = 500;
/** Answers to older ones no longer matter. */
const REMEMBERED = 64;

/**
 * Says all that is held of the robot's controls while anything is, and what this page sets until it
 * has arrived: the channel may lose every message.
 *
 * Its timer runs on the main thread on purpose, as that of `CommandSender` does.
 */
export class OperateSender {
  #seq = 0;
  #wishes = new Map<string, Wish>();
  #said = new Map<number, Readonly<Record<string, number>>>();
  #wishedMs = Number.NEGATIVE_INFINITY;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #dueMs = 0;
  #repeats: ReturnType<typeof setTimeout>[] = [];

  constructor(private readonly options: OperateSenderOptions) {}

  /** Sets a control, now and again until it has arrived. */
  set(name: string, value: number): void {
    this.#wishes.set(name, { value, sinceMs: performance.now(), takenMs: null });
    this.#tell();
    // A slider that is dragged sets something all the time; its newest value goes with the next.
    if (performance.now() - this.#wishedMs >= WISHES_EVERY_MS) this.send();
    else this.#schedule();
  }

  /** Sends what is held and set, now; then as long as there is something. */
  send(urgent = false): void {
    this.#say(urgent);
    this.#schedule();
  }

  /** Says that something was released, now and twice more. */
  repeat(): void {
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
    this.send(true);
    this.#repeats = AGAIN_AFTER_MS.map((ms) => setTimeout(() => this.#say(true), ms));
  }

  /** Says it three times at once: the browser may let the page do nothing after this. */
  repeatAtOnce(): void {
    for (const _ of AGAIN_AFTER_MS) this.#say(true);
    this.repeat();
  }

  /** Gives up what has not arrived, as when nobody may set it any more. */
  forget(): void {
    if (this.#wishes.size === 0) return;
    this.#wishes.clear();
    this.#tell();
  }

  /** Handles the server's answer; returns whether it refuses. */
  answered({ seq, refused }: Operated): boolean {
    for (const [name, value] of Object.entries(this.#said.get(seq) ?? {})) {
      const wish = this.#wishes.get(name);
      if (wish?.value !== value) continue;
      if (refused) this.#wishes.delete(name);
      else wish.takenMs ??= performance.now();
    }
    if (refused === null) return false;
    this.#tell();
    this.options.refused(refused);
    return true;
  }

  /** Handles what the room says of the controls that were set. */
  told(values: Readonly<Record<string, number>>): void {
    const before = this.#wishes.size;
    for (const [name, { value, takenMs }] of this.#wishes) {
      if (takenMs !== null && values[name] === value) this.#wishes.delete(name);
    }
    if (this.#wishes.size < before) this.#tell();
  }

  #say(urgent: boolean): void {
    const { held, turn, serverMs, beat, send } = this.options;
    const nowMs = performance.now();
    const sentMs = serverMs();
    if (sentMs === null) return;
    const wanted: Record<string, number> = {};
    if (nowMs - this.#wishedMs >= WISHES_EVERY_MS) {
      const open = [...this.#wishes].filter(([, { takenMs }]) => takenMs === null);
      for (const [name, { value }] of open.slice(0, MOST_WISHES)) wanted[name] = value;
      if (open.length > 0) this.#wishedMs = nowMs;
    }
    const seq = this.#seq++;
    this.#said.set(seq, wanted);
    this.#said.delete(seq - REMEMBERED);
    send(
      {
        type: "operate",
        seq,
        turn: turn(),
        sent_server_ms: sentMs,
        held: held(),
        wanted,
        beat: beat(),
      },
      urgent,
    );
  }

  #schedule(): void {
    clearTimeout(this.#timer);
    if (Object.keys(this.options.held()).length + this.#wishes.size === 0) return;
    this.#dueMs = performance.now() + EVERY_MS;
    this.#timer = setTimeout(() => this.#tick(), EVERY_MS);
  }

  #tick(): void {
    const nowMs = performance.now();
    if (nowMs - this.#dueMs > HUNG_MS) this.options.hung();
    const before = this.#wishes.size;
    let isLost = false;
    for (const [name, { sinceMs, takenMs }] of this.#wishes) {
      const isGivenUp = takenMs === null && nowMs - sinceMs > GIVE_UP_MS;
      if (isGivenUp || (takenMs !== null && nowMs - takenMs > TOLD_WITHIN_MS)) {
        this.#wishes.delete(name);
      }
      isLost ||= isGivenUp;
    }
    if (this.#wishes.size < before) this.#tell();
    if (isLost) this.options.refused(null);
    const isOpen = [...this.#wishes.values()].some(({ takenMs }) => takenMs === null);
    const isHeld = Object.keys(this.options.held()).length > 0;
    if (isHeld || (isOpen && nowMs - this.#wishedMs >= WISHES_EVERY_MS)) this.#say(false);
    this.#schedule();
  }

  #tell(): void {
    this.options.wants(
      Object.fromEntries([...this.#wishes].map(([name, { value }]) => [name, value])),
    );
  }
}
