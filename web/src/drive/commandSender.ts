import type { Drive } from "../messages";
import type { Motion } from "./inputState";
import { Rate, type Way } from "./rate";

/** What a set-point is made of, read live at the moment of sending. */
export interface Controls {
  motion: Motion;
  /** The dead-man: some control is held down. */
  held: boolean;
  speed: Drive["speed"];
  /** Positions, of the axes that have a hand on them. */
  axes: Record<string, number>;
}

export interface CommandSenderOptions {
  controls: () => Controls;
  /** The time on the server's clock, null while the clocks are not aligned. */
  serverMs: () => number | null;
  /** Capture time of the newest presented picture, null when none is known. */
  seenServerMs: () => number | null;
  way: () => Way;
  /** The page hung, and what the hands did meanwhile it has yet to hear; called before it sends. */
  hung: () => void;
  send: (drive: Drive, urgent: boolean) => void;
}

/** A release is said three times, since the channel may lose any of them. */
const AGAIN_AFTER_MS = [45, 90] as const;
/**
 * A page on which nothing is held would be safe in silence too. It sends 20 times a second all the
 * same: the server must have heard that nothing is held before the next press may move anything.
 */
const REST_HZ = 20;
const REST_AFTER_MS = 500;
/** A timer so late tells of a page that hung, or a computer that slept. */
const HUNG_MS = 500;

/**
 * Sends complete set-points while this page drives, and nothing otherwise.
 *
 * Its timer is the main thread's on purpose. A worker's would go on while the page is frozen, and
 * say that something is held for somebody whom the page no longer hears letting go: a page that
 * hangs must fall silent. Browsers do not slow a timer of a page in the foreground; in the
 * background nothing is held.
 */
export class CommandSender {
  #seq = 0;
  #turn: number | null = null;
  #rate = new Rate(0);
  #hz = 0;
  #busyMs = 0;
  #dueMs = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #repeats: ReturnType<typeof setTimeout>[] = [];

  constructor(private readonly options: CommandSenderOptions) {}

  /** Sends for this turn from now on, never more often than `maxHz`; changes come on top. */
  begin(turn: number, maxHz: number): void {
    this.end();
    this.#turn = turn;
    this.#rate = new Rate(maxHz);
    this.#busyMs = performance.now();
    this.#dueMs = this.#busyMs;
    this.#tick();
  }

  end(): void {
    this.#turn = null;
    clearTimeout(this.#timer);
    this.#forgetRepeats();
  }

  /** Sends the set-point of this moment; called by the timer, and at once on every change. */
  send(urgent = false): void {
    if (this.#turn === null) return;
    this.#say(urgent);
    clearTimeout(this.#timer);
    const everyMs = 1000 / this.#pace();
    this.#dueMs = performance.now() + everyMs;
    this.#timer = setTimeout(() => this.#tick(), everyMs);
  }

  /** Sends what is held after a release, now and again twice. */
  insist(): void {
    this.#forgetRepeats();
    this.send(true);
    this.#repeats = AGAIN_AFTER_MS.map((ms) => setTimeout(() => this.send(true), ms));
  }

  /** Says it three times at once: this may be the last that the browser lets the page do. */
  insistNow(): void {
    for (const _ of AGAIN_AFTER_MS) this.send(true);
    this.insist();
  }

  #say(urgent: boolean): void {
    const serverMs = this.options.serverMs();
    if (this.#turn === null || serverMs === null) return;
    const { motion, held, speed, axes } = this.options.controls();
    this.options.send(
      {
        type: "drive",
        seq: this.#seq++,
        turn: this.#turn,
        sent_server_ms: serverMs,
        ...motion,
        held,
        speed,
        seen_server_ms: this.options.seenServerMs(),
        axes,
      },
      urgent,
    );
  }

  /** Looks at the way before it sends: what it has just said itself is no backlog. */
  #tick(): void {
    const nowMs = performance.now();
    if (nowMs - this.#dueMs > HUNG_MS) this.options.hung();
    this.#hz = this.#rate.next(this.options.way(), nowMs);
    this.send();
  }

  #pace(): number {
    const nowMs = performance.now();
    if (this.options.controls().held) this.#busyMs = nowMs;
    const isAtRest = nowMs - this.#busyMs > REST_AFTER_MS;
    return isAtRest ? Math.min(this.#hz, REST_HZ) : this.#hz;
  }

  #forgetRepeats(): void {
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
  }
}
