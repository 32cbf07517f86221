import type { ServerClock } from "../clock";
import type { Ping, Pong } from "../messages";

const EAGER_MS = 1000;
/** So many answers align the clock well enough to begin with. */
const EAGER_PONGS = 6;
const EAGER_EVERY_MS = 50;
const KEEN_EVERY_MS = 200;
const CALM_EVERY_MS = 1000;
const SILENCE_MS = 3000;

/** Pings, what the pongs tell the clock, and whether the other side is still there. Pure. */
export class Heartbeat {
  #nextId = 1;
  #startedMs: number | null = null;
  #newest: { id: number; atMs: number } | null = null;
  #unansweredSinceMs: number | null = null;
  #pongs = 0;

  constructor(private readonly clock: ServerClock) {}

  /** The next ping, to be sent now. */
  beat(nowMs: number): Ping {
    this.#startedMs ??= nowMs;
    this.#unansweredSinceMs ??= nowMs;
    return {
      type: "ping",
      id: this.#nextId++,
      sent_page_ms: nowMs,
      pong_id: this.#newest?.id ?? null,
      pong_held_ms: this.#newest && nowMs - this.#newest.atMs,
    };
  }

  /** Takes an answer; an older one than the newest still helps the clock. */
  heard(pong: Pong, nowMs: number): void {
    this.#unansweredSinceMs = null;
    this.#pongs++;
    this.clock.add({ sentMs: pong.sent_page_ms, serverMs: pong.server_ms, receivedMs: nowMs });
    if (pong.id > (this.#newest?.id ?? 0)) this.#newest = { id: pong.id, atMs: nowMs };
  }

  /**
   * The pause before the next ping: eager at first, so that the clock aligns soon; keen for
   * whoever needs to be heard often; calm for all others.
   */
  pauseMs(nowMs: number, isKeen: boolean): number {
    const isNew = nowMs - (this.#startedMs ?? nowMs) < EAGER_MS;
    if (isNew && this.#pongs < EAGER_PONGS) return EAGER_EVERY_MS;
    return isKeen ? KEEN_EVERY_MS : CALM_EVERY_MS;
  }

  /** For how long pings have gone unanswered; 0 where none has. */
  unansweredMs(nowMs: number): number {
    return nowMs - (this.#unansweredSinceMs ?? nowMs);
  }

  /** True when pings have gone unanswered for 3 s. */
  isSilent(nowMs: number): boolean {
    return this.unansweredMs(nowMs) >= SILENCE_MS;
  }
}
