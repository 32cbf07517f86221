/** When to ping, and when missing answers mean a lost link; earlier signs: `silence.ts`. Pure. */

import type { Ping, Pong } from "../messages";
import type { ServerClock } from "../serverClock";

const EAGER_MS = 1000;
/** This many answers align the clock well enough at the start. */
const EAGER_PONGS = 6;
const EAGER_EVERY_MS = 50;
/** With more pings unanswered, the next would only queue behind them. */
const EAGER_UNANSWERED = 2;
const KEEN_EVERY_MS = 200;
const CALM_EVERY_MS = 1000;
const SILENCE_MS = 3000;
/** For a page that drives or waits; longer for observers, lest a crowd reconnect at once. */
const KEEN_SILENCE_MS = 2000;
/** A gap between pings counts at most this much: a page that hung could not receive answers. */
const LONGEST_STEP_MS = 1500;

/** Pings, the clock measurements from the pongs, and whether the server still answers. Pure. */
export class Heartbeat {
  #nextId = 1;
  #startedMs: number | null = null;
  #newest: { id: number; atMs: number } | null = null;
  #unansweredSinceMs: number | null = null;
  #beatMs = 0;
  #pongs = 0;
  #beat: string | null = null;

  constructor(private readonly clock: ServerClock) {}

  /** Returns the next ping, to be sent now. */
  nextPing(nowMs: number): Ping {
    this.#startedMs ??= nowMs;
    this.#unansweredSinceMs = nowMs - this.unansweredMs(nowMs);
    this.#beatMs = nowMs;
    return {
      type: "ping",
      id: this.#nextId++,
      sent_page_ms: nowMs,
      pong_id: this.#newest?.id ?? null,
      pong_held_ms: this.#newest && nowMs - this.#newest.atMs,
    };
  }

  /** The newest beat; each command names it, so that the server need not trust our clock. */
  get newestBeat(): string | null {
    return this.#beat;
  }

  /** Stores a beat that arrived between two pongs. */
  storeBeat(beat: string): void {
    this.#beat = beat;
  }

  /** Handles an answer; even a late one helps the clock. */
  handlePong(pong: Pong, nowMs: number): void {
    this.storeBeat(pong.beat);
    this.#unansweredSinceMs = null;
    this.#pongs++;
    this.clock.add({ sentMs: pong.sent_page_ms, serverMs: pong.server_ms, receivedMs: nowMs });
    if (pong.id > (this.#newest?.id ?? 0)) this.#newest = { id: pong.id, atMs: nowMs };
  }

  /**
   * The pause before the next ping: short at first, to align the clock soon; medium for a page
   * whose silence must be noticed soon; long for all others.
   */
  pauseMs(nowMs: number, isKeen: boolean): number {
    const isNew = nowMs - (this.#startedMs ?? nowMs) < EAGER_MS;
    if (isNew && this.#pongs < EAGER_PONGS) {
      const unanswered = this.#nextId - 1 - this.#pongs;
      return unanswered > EAGER_UNANSWERED ? KEEN_EVERY_MS : EAGER_EVERY_MS;
    }
    return isKeen ? KEEN_EVERY_MS : CALM_EVERY_MS;
  }

  /** Stops expecting answers to pings sent into a network that is gone. */
  forgetUnanswered(): void {
    this.#unansweredSinceMs = null;
  }

  /** How long pings have gone unanswered; 0 if none has. */
  unansweredMs(nowMs: number): number {
    if (this.#unansweredSinceMs === null) return 0;
    const stoodMs = Math.max(0, nowMs - this.#beatMs - LONGEST_STEP_MS);
    return nowMs - this.#unansweredSinceMs - stoodMs;
  }

  /** Whether pings have gone unanswered for 3 s, or for 2 s if `isKeen`. */
  isSilent(nowMs: number, isKeen: boolean): boolean {
    return this.unansweredMs(nowMs) >= (isKeen ? KEEN_SILENCE_MS : SILENCE_MS);
  }
}
