/** When a set-point is sent; how often while held: `sendRate.ts`; its motion: `inputState.ts`. */

import type { Drive } from "../messages";
import type { Motion } from "./inputState";
import { SendRate, type Uplink } from "./sendRate";

/** The parts of a set-point, read at the moment of sending. */
export interface Controls {
  motion: Motion;
  /** The dead-man: some control is held down. */
  held: boolean;
  speed: Drive["speed"];
  /** The positions of the axes being held. */
  axes: Record<string, number>;
}

export interface CommandSenderOptions {
  controls: () => Controls;
  /** The time on the server's clock, null while the clocks are not aligned. */
  serverMs: () => number | null;
  /** The newest beat received from the server, null before the first. */
  beat: () => string | null;
  /** The capture time of the newest picture on screen, null if unknown. */
  seenServerMs: () => number | null;
  uplink: () => Uplink;
  /** Called before sending if the page hung and has yet to process the input of that time. */
  hung: () => void;
  send: (drive: Drive, urgent: boolean) => void;
}

/** A release is sent three times, since the channel may lose any of them. */
const AGAIN_AFTER_MS = [45, 90] as const;
const REST_AFTER_MS = 500;
/**
 * A moving stick is sent at once at most this often; in between it is sent with the next set-point.
 * Both together stay below the server's rate limit for a page.
 */
const DEFLECTED_EVERY_MS = 125;
/** A timer this late means that the page hung or the computer slept. */
const HUNG_MS = 500;

/**
 * Sends complete set-points while this page drives, and nothing otherwise.
 *
 * The timer runs on the main thread on purpose. In a worker it would keep running while the page
 * hangs, and keep sending that a control is held after its release: a page that hangs must fall
 * silent. Browsers do not throttle timers of a foreground page; in the background nothing is held.
 */
export class CommandSender {
  #seq = 0;
  #turn: number | null = null;
  #rate = new SendRate(0);
  #hz = 0;
  #busyMs = 0;
  #dueMs = 0;
  #deflectedMs = Number.NEGATIVE_INFINITY;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #repeats: ReturnType<typeof setTimeout>[] = [];

  constructor(private readonly options: CommandSenderOptions) {}

  /** Starts sending for this turn, at up to `maxHz`; changes are sent in addition. */
  begin(turn: number, maxHz: number): void {
    this.end();
    this.#turn = turn;
    this.#rate = new SendRate(maxHz);
    this.#busyMs = performance.now();
    this.#dueMs = this.#busyMs;
    this.#tick();
  }

  end(): void {
    this.#turn = null;
    clearTimeout(this.#timer);
    this.#forgetRepeats();
  }

  /** Sends the current set-point; called by the timer, and at once on every change. */
  send(urgent = false): void {
    if (this.#turn === null) return;
    this.#say(urgent);
    clearTimeout(this.#timer);
    const everyMs = 1000 / this.#pace();
    this.#dueMs = performance.now() + everyMs;
    this.#timer = setTimeout(() => this.#tick(), everyMs);
  }

  /** Handles a stick that was moved: sends the set-point at once, or with the next one due. */
  deflected(): void {
    const nowMs = performance.now();
    if (nowMs - this.#deflectedMs < DEFLECTED_EVERY_MS) return;
    this.#deflectedMs = nowMs;
    this.send();
  }

  /** Sends the state after a release, now and twice more. */
  repeat(): void {
    this.#forgetRepeats();
    this.send(true);
    this.#repeats = AGAIN_AFTER_MS.map((ms) => setTimeout(() => this.send(true), ms));
  }

  /** Sends the state three times at once: the browser may not let the page run again. */
  repeatAtOnce(): void {
    for (const _ of AGAIN_AFTER_MS) this.send(true);
    this.repeat();
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
        beat: this.options.beat(),
      },
      urgent,
    );
  }

  /** Reads the backlog before sending, so that this message does not count. */
  #tick(): void {
    const nowMs = performance.now();
    if (nowMs - this.#dueMs > HUNG_MS) this.options.hung();
    this.#hz = this.#rate.next(this.options.uplink(), nowMs);
    this.send();
  }

  #pace(): number {
    const nowMs = performance.now();
    if (this.options.controls().held) this.#busyMs = nowMs;
    const isAtRest = nowMs - this.#busyMs > REST_AFTER_MS;
    return isAtRest ? Math.min(this.#hz, this.#rate.restHz) : this.#hz;
  }

  #forgetRepeats(): void {
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
  }
}
