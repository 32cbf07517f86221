/** When the robot's held and set controls are sent; which they are: `operating.ts`. */

import type { Operate, Operated, Sentence } from "../messages";

export interface OperateSenderOptions {
  /** The values of the controls held now, by name. */
  held: () => Record<string, number>;
  /** The turn's number while this page drives, else 0. */
  turn: () => number;
  /** The time on the server's clock, null while the clocks are not aligned. */
  serverMs: () => number | null;
  /** The newest beat received from the server, null before the first. */
  beat: () => string | null;
  send: (operate: Operate, urgent: boolean) => void;
  /** Called if the page hung, and so has not yet processed the input of that time. */
  hung: () => void;
  /** Called whenever `wanted` changes. */
  wants: (wanted: Readonly<Record<string, number>>) => void;
  /** Called when something has no effect, with the reason; null if it did not arrive. */
  refused: (why: Sentence | null) => void;
}

interface Wish {
  value: number;
  sinceMs: number;
  /** When the server accepted it; it stays shown until the room confirms it, too. */
  takenMs: number | null;
}

/** The interval of set-points at their slowest: the server holds a control no longer than one. */
const EVERY_MS = 50;
/** Set values are repeated within the server's rate limit. */
const WISHES_EVERY_MS = 110;
const MOST_WISHES = 2;
/** A release is sent three times, as for set-points, since the channel may lose any of them. */
const AGAIN_AFTER_MS = [45, 90] as const;
/** A value that has not arrived by then is dropped, so that it takes no unexpected effect. */
const GIVE_UP_MS = 3000;
/** The room confirms an accepted value within this time. */
const TOLD_WITHIN_MS = 1500;
const HUNG_MS = 500;
/** Answers to older messages no longer matter. */
const REMEMBERED = 64;

/**
 * Repeats all held controls while any is held, and each set value until the server has answered:
 * the channel may lose any message.
 *
 * The timer runs on the main thread on purpose, as in `CommandSender`.
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

  /** Sends a control's value, and repeats it until the server has answered. */
  set(name: string, value: number): void {
    this.#wishes.set(name, { value, sinceMs: performance.now(), takenMs: null });
    this.#tell();
    // A dragged slider sets values all the time; the newest goes with the next message.
    if (performance.now() - this.#wishedMs >= WISHES_EVERY_MS) this.send();
    else this.#schedule();
  }

  /** Sends what is held and set now, and repeats it while there is anything. */
  send(urgent = false): void {
    this.#say(urgent);
    this.#schedule();
  }

  /** Sends the state after a release, now and twice more. */
  repeat(): void {
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
    this.send(true);
    this.#repeats = AGAIN_AFTER_MS.map((ms) => setTimeout(() => this.#say(true), ms));
  }

  /** Sends the state three times at once: the browser may not let the page run again. */
  repeatAtOnce(): void {
    for (const _ of AGAIN_AFTER_MS) this.#say(true);
    this.repeat();
  }

  /** Drops the values that have not arrived, as when the user may no longer set them. */
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

  /** Forgets the accepted values that the room now shows. */
  confirm(values: Readonly<Record<string, number>>): void {
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
