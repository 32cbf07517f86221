import type { Seat } from "../messages";

/** Without a picture for this long a LiveKit room counts as gone. */
const FIRST_PATIENCE_MS = 500;
/** The most patience: if every room stalls, the link does, and switching makes it worse. */
const MOST_PATIENCE_MS = 8000;
/** After this long with a picture, patience is reset and failed rooms may be tried again. */
const STEADY_MS = 10_000;
/** A longer gap between calls means that the page did not run and could not see anything. */
const LONGEST_STEP_MS = 200;

/** Which of the LiveKit rooms to watch, and when to switch to the next. Pure. */
export class Failover {
  #seats: Seat[] = [];
  /** The rooms that have failed. */
  readonly #failed = new Set<string>();
  #current: string | null = null;
  #patienceMs = FIRST_PATIENCE_MS;
  #lookedMs = 0;
  #quietMs = 0;
  #steadyMs = 0;

  /** Sets the rooms, or fresh tokens for them; rooms that failed may be tried again. */
  offer(seats: Seat[]): void {
    this.#seats = seats;
    this.#failed.clear();
  }

  /** The first room that has not failed, other than the current one; null if there is none. */
  next(): Seat | null {
    const isGood = (seat: Seat) =>
      !this.#failed.has(nameOf(seat)) && nameOf(seat) !== this.#current;
    return this.#seats.find(isGood) ?? null;
  }

  /** Records that this room plays from now on. */
  plays(seat: Seat, nowMs: number): void {
    this.#current = nameOf(seat);
    this.#steadyMs = 0;
    this.restartWait(nowMs);
  }

  /** Excludes this room until `offer`. */
  failed(seat: Seat): void {
    this.#failed.add(nameOf(seat));
    if (nameOf(seat) === this.#current) this.#current = null;
  }

  /** Restarts the wait. */
  restartWait(nowMs: number): void {
    this.#quietMs = 0;
    this.#lookedMs = nowMs;
  }

  /**
   * Whether the room has been frozen for too long; call it several times a second. `moves` says
   * that there was a picture since the last call, or that none is expected.
   */
  hasStood(nowMs: number, moves: boolean): boolean {
    const stepMs = Math.min(nowMs - this.#lookedMs, LONGEST_STEP_MS);
    this.#lookedMs = nowMs;
    this.#quietMs = moves ? 0 : this.#quietMs + stepMs;
    this.#steadyMs = this.#quietMs < FIRST_PATIENCE_MS ? this.#steadyMs + stepMs : 0;
    if (this.#steadyMs >= STEADY_MS) {
      this.#patienceMs = FIRST_PATIENCE_MS;
      this.#failed.clear();
    }
    if (this.#quietMs < this.#patienceMs) return false;
    this.#patienceMs = Math.min(2 * this.#patienceMs, MOST_PATIENCE_MS);
    return true;
  }
}

/** Whether both seats are in the same room. */
export function isSameRoom(one: Seat, other: Seat): boolean {
  return nameOf(one) === nameOf(other);
}

/** Identifies a room, also among several on one server: its token says which it opens. */
function nameOf({ url, token }: Seat): string {
  return `${url} ${roomIn(token)}`;
}

/** The room in a token's claims (RFC 7519); the token itself where it has none. */
function roomIn(token: string): string {
  try {
    const claims = (token.split(".")[1] ?? "").replaceAll("-", "+").replaceAll("_", "/");
    return JSON.parse(atob(claims)).video.room;
  } catch {
    return token;
  }
}
