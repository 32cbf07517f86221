/** In which order packets are decoded, and how long one waits for earlier ones. Pure. */

import { opusTicks } from "./opus";
import type { Block } from "./red";

/** How long packets wait for a missing earlier one, which may only have been overtaken. */
const WAIT_MS = 20;
/** A larger jump of RTP time means that the sender has changed. */
const ANEW_TICKS = 10 * 48_000;

/**
 * Puts packets in order for a decoder, which can only go forward: each once, and none older than
 * what has been decoded. Pure.
 */
export class Sequence {
  /** The RTP time after the newest packet that was decoded. */
  #end: number | null = null;
  #waiting: (Block & { sinceMs: number })[] = [];

  /** Adds the packets of one arrival; returns those to be decoded now, in order. */
  add(blocks: Block[], nowMs: number): Block[] {
    for (const block of blocks) {
      if (opusTicks(block.data) === 0) continue;
      const ahead = this.#ahead(block.rtp);
      if (Math.abs(ahead) > ANEW_TICKS) this.#anew();
      else if (ahead < 0 || this.#waiting.some((one) => one.rtp === block.rtp)) continue;
      this.#waiting.push({ ...block, sinceMs: nowMs });
    }
    this.#waiting.sort((a, b) => this.#ahead(a.rtp) - this.#ahead(b.rtp));
    return this.due(nowMs);
  }

  /** Returns the packets that are next or have waited long enough. */
  due(nowMs: number): Block[] {
    const ready: Block[] = [];
    for (;;) {
      const [first] = this.#waiting;
      if (!first) break;
      const isNext = this.#end === null || this.#ahead(first.rtp) === 0;
      if (!isNext && nowMs - first.sinceMs < WAIT_MS) break;
      this.#waiting.shift();
      // Do not play again what overlaps with a packet already decoded.
      if (this.#ahead(first.rtp) < 0) continue;
      this.#end = (first.rtp + opusTicks(first.data)) >>> 0;
      ready.push({ rtp: first.rtp, data: first.data });
    }
    return ready;
  }

  /** When to call `due` again, null if nothing waits. */
  get nextDueMs(): number | null {
    const [first] = this.#waiting;
    return first ? first.sinceMs + WAIT_MS : null;
  }

  #anew(): void {
    this.#end = null;
    this.#waiting = [];
  }

  /** RTP time wraps at 2³² (RFC 3550, 5.1). */
  #ahead(rtp: number): number {
    return this.#end === null ? 0 : (rtp - this.#end) | 0;
  }
}
