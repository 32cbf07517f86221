import type { Seat } from "../messages";

/** Without a picture for so long a room counts as gone. */
const FIRST_PATIENCE_MS = 500;
/** Where every room stalls, the link does: going to and fro would make that worse. */
const MOST_PATIENCE_MS = 8000;
/** After so long with a picture a room is good again, and so are those that failed before. */
const STEADY_MS = 10_000;
/** A longer gap between calls means that the page did not run and could not see anything. */
const LONGEST_STEP_MS = 200;

/** Which of the rooms to watch, and when to go to the next one. Pure. */
export class Failover {
  #seats: Seat[] = [];
  /** The rooms that do not play. */
  readonly #failed = new Set<string>();
  #current: string | null = null;
  #patienceMs = FIRST_PATIENCE_MS;
  #lookedMs = 0;
  #quietMs = 0;
  #steadyMs = 0;

  /** Sets the rooms, or fresh tokens for them; whichever failed may be tried again. */
  offer(seats: Seat[]): void {
    this.#seats = seats;
    this.#failed.clear();
  }

  /** The first room that may play, other than the one that is watched; null if there is none. */
  next(): Seat | null {
    const isGood = (seat: Seat) =>
      !this.#failed.has(nameOf(seat)) && nameOf(seat) !== this.#current;
    return this.#seats.find(isGood) ?? null;
  }

  /** This room plays from now on. */
  plays(seat: Seat, nowMs: number): void {
    this.#current = nameOf(seat);
    this.#steadyMs = 0;
    this.begin(nowMs);
  }

  /** This room does not play: the next one is another, until `offer`. */
  failed(seat: Seat): void {
    this.#failed.add(nameOf(seat));
    if (nameOf(seat) === this.#current) this.#current = null;
  }

  /** Begins to wait anew. */
  begin(nowMs: number): void {
    this.#quietMs = 0;
    this.#lookedMs = nowMs;
  }

  /**
   * Whether the room has stood still for too long; to be called several times a second. `moves`
   * says that there was a picture since the call before, or that none is expected.
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

/** Whether both are of the same room. */
export function isSameRoom(one: Seat, other: Seat): boolean {
  return nameOf(one) === nameOf(other);
}

/** What tells a room from others, on the same server too: its token says which it opens. */
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
