import { RequestError } from "../link/http";
import type { Link, LinkState } from "../link/link";
import type { Sent } from "../link/signalling";
import { Silence } from "../link/silence";
import type { Receivers } from "../measure/report";
import type { RoomState, Told, ViewerInfo } from "../messages";
import { ServerClock } from "../serverClock";
import type { State } from "../state";
import { pageSentence, type Saying } from "../words/said";
import { t } from "../words/words";
import { InStep } from "./inStep";
import { postLeave, postQueue, postSeat, type Wants } from "./queueing";
import { RenditionChoice } from "./rendition";
import { ToldClock } from "./toldClock";
import { mayGo, mustCome, withMe } from "./visit";
import { Watch } from "./watch";

export interface RoomViewerOptions {
  state: State;
  link: Pick<Link, "connect" | "close">;
  client: () => string;
  wants: () => { sound: boolean; picture: boolean };
  /** The size that is enough, as `640x480`. */
  size: () => string;
  /** Plays these receivers instead of the previous ones. */
  show: (receivers: Receivers) => void;
  enterRoom: (room: RoomState) => void;
  /** Shows a sentence to the user. */
  say: (sentence: string | Saying) => void;
}

const LOOK_EVERY_MS = 50;
/** Tokens are valid for five minutes. */
const RENEW_MS = 240_000;
/** The renewal after a turn, when the tokens' age is unknown. */
const RENEW_SOON_MS = 2000;
/** The retry if the robot's server could not renew the tokens; the room plays on. */
const AGAIN_MS = 15_000;
/** The pause before asking the robot's server again, by the number of failures in a row. */
const RETRY_MS = [0, 1000, 2000, 4000, 8000] as const;
const LONGEST_RETRY_MS = 10_000;
const STAY_EVERY_MS = 5000;
/** The broadcast room state may reflect a request this much later than its answer. */
const TOLD_LATE_MS = 3000;
/** The robot's server sends a message every second. */
const SILENT_MS = 2500;

const CONNECTING: LinkState = { is: "connecting", reason: null };

/** What plays: a LiveKit room, the robot's server, or nothing yet. */
type Place = "room" | "server" | null;

/**
 * The page while the robot's server is full: it watches a LiveKit room, queues by HTTP, connects to
 * the server for its turn and returns to the room afterwards. At each switch the old picture stays
 * on the screen until the new one has arrived.
 */
export class RoomViewer {
  readonly #rendition = new RenditionChoice();
  readonly #watch: Watch;
  readonly #inStep: InStep;
  readonly #clock = new ToldClock();
  /** The robot's wall clock, by which captures are stamped. */
  readonly #wall = new ServerClock();
  #onScreen: Place = null;
  #link: LinkState = { is: "closed" };
  #roomLink = CONNECTING;
  /** The silence of the robot's server, whose messages arrive through the room. */
  #silence = new Silence(0);
  #isSilent = false;
  /** Whether this page is now a viewer at the robot's server. */
  #isServed = false;
  /** Whether it connects there for its turn. */
  #isVisiting = false;
  #isReturning = false;
  /** The peer to the server whose first picture is awaited, and what shows it. */
  #arriving: { picture: RTCRtpReceiver; show: () => void } | null = null;
  /** This page's number in the queue, null while it has none. */
  #number: number | null = null;
  #askedMs = 0;
  #failures = 0;
  #asking: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly options: RoomViewerOptions) {
    const { state, wants, size } = options;
    this.#watch = new Watch({
      rendition: this.#rendition,
      wants,
      size,
      isPictureExpected: () => isPictureExpected(state.room.peek()),
      events: {
        show: (receivers) => this.#show(receivers),
        told: (told) => this.#told(told),
        plays: (isPlaying) => this.#plays(isPlaying),
        failed: () => this.#failed(),
      },
    });
    this.#inStep = new InStep({
      wants,
      rendition: this.#rendition,
      isPictureFirst: () => state.preferences.peek().policy === "video-first",
      wall: this.#wall,
      onFacts: (facts) => {
        if (this.isOnScreen) state.facts.value = facts;
      },
      onPlayout: (playout) => {
        if (this.isOnScreen) state.playout.value = playout;
      },
    });
    setInterval(() => this.#check(performance.now()), LOOK_EVERY_MS);
  }

  /** Whether the picture on the screen comes from a LiveKit room. */
  get isOnScreen(): boolean {
    return this.#onScreen === "room";
  }

  /** The receiver of a LiveKit room's picture on the screen; undefined for none. */
  get picture(): RTCRtpReceiver | undefined {
    return this.#inStep.picture;
  }

  /** The server's clock, as far as it is known here. */
  toServerMs(pageMs: number): number | null {
    return this.#clock.toServerMs(pageMs);
  }

  // --- called by the session -----------------------------------------------------------------

  /** Watches the rooms that the robot's server names because it is full. */
  sent(where: Sent): void {
    const { state } = this.options;
    const { sentMs, receivedMs, wall_ms } = where;
    this.#wall.add({ sentMs, receivedMs, serverMs: wall_ms });
    const me = state.me.peek();
    this.#number = me && me.role !== "observer" ? me.id : null;
    this.#isServed = this.#isVisiting = this.#isReturning = false;
    this.#arriving = null;
    if (this.#onScreen === "server") this.#watch.resume(performance.now());
    state.isInRoom.value = true;
    state.links.value = where.links;
    if (!this.#watch.hasRoom) this.#roomLink = CONNECTING;
    state.hello.value = { ...where.hello, viewer: this.#number ?? 0 };
    this.#renewIn(RENEW_MS * (0.9 + Math.random() / 5));
    if (where.rooms.length === 0 && !this.#watch.hasRoom) this.#failed();
    else this.#watch.offer(where.rooms, performance.now());
    this.#tellLink();
  }

  /** Handles the state of the link to the robot's server. */
  linkChanged(link: LinkState): void {
    this.#link = link;
    if (link.is === "connected" && !this.#isServed) {
      this.#isServed = true;
      clearTimeout(this.#asking);
      this.options.state.isInRoom.value = false;
      this.options.state.watching.value = null;
      this.options.state.links.value = [];
    }
    const isTrying = link.is === "waiting" || (link.is === "connecting" && link.reason !== null);
    const isNeeded = this.#isServed || this.#isVisiting || this.#roomLink.is !== "connected";
    if (isTrying && !isNeeded) {
      // The link is about to set its timer for the next attempt.
      queueMicrotask(() => this.options.link.close());
      this.#renewIn(AGAIN_MS * (1 + Math.random()));
    }
    this.#tellLink();
  }

  /** Calls `show` once this accepted peer's picture has arrived, or this page's turn has begun. */
  arrives(picture: RTCRtpReceiver, show: () => void): void {
    this.#arriving = { picture, show };
    this.#arrive();
  }

  /** Sends a queue request by HTTP; returns false if the page is connected to the server. */
  ask(wants: Wants): boolean {
    if (this.#isServed) return false;
    void this.#post(wants).catch((error: unknown) => {
      if (error instanceof RequestError) this.options.say(error.saying);
    });
    return true;
  }

  presented(rtp: number | undefined, atMs: number): void {
    this.#inStep.presented(rtp, atMs);
  }

  /** Stops watching, until the server sends the page here again. */
  leave(): void {
    clearTimeout(this.#asking);
    this.#watch.leave();
    this.#inStep.setReceivers(null);
    this.#onScreen = this.#arriving = null;
    this.#roomLink = CONNECTING;
    this.#isServed = this.#isVisiting = this.#isReturning = false;
  }

  /** Gives the seat to others when the page is closed or goes to the background. */
  giveUp(): void {
    if (this.#watch.hasRoom) postLeave(this.options.client());
  }

  // --- LiveKit rooms -------------------------------------------------------------------------

  #check(nowMs: number): void {
    this.#watch.check(nowMs);
    if (this.isOnScreen) this.#inStep.readCaptures(nowMs);
    this.#arrive();
    this.#return(nowMs);
    this.#listen(nowMs);
    if (this.#number !== null && !this.#isServed && nowMs - this.#askedMs >= STAY_EVERY_MS) {
      // Whether the place is kept shows in the broadcast room state.
      this.#post("stay").catch(() => {});
    }
  }

  /** Notices when the robot's server has fallen silent; the room may play on. */
  #listen(nowMs: number): void {
    this.#silence.update(nowMs);
    const isSilent = this.#silence.quietMs > SILENT_MS;
    if (isSilent === this.#isSilent) return;
    this.#isSilent = isSilent;
    this.#tellLink();
  }

  #show(receivers: Receivers): void {
    if (this.#isReturning) this.#leaveServer();
    this.#onScreen = "room";
    this.options.show(receivers);
    this.#inStep.setReceivers(receivers);
  }

  #plays(isPlaying: boolean): void {
    if (isPlaying) {
      this.#failures = 0;
      this.#silence.heard(performance.now());
    }
    this.#roomLink = isPlaying
      ? { is: "connected" }
      : { is: "connecting", reason: pageSentence("link.stood") };
    this.#tellLink();
  }

  #failed(): void {
    if (this.#isServed) {
      this.#watch.leave();
      this.#isVisiting = this.#isReturning = false;
      return;
    }
    const pauseMs = RETRY_MS[this.#failures++] ?? LONGEST_RETRY_MS;
    const retryAtMs = performance.now() + pauseMs;
    this.#roomLink = { is: "waiting", retryAtMs, reason: pageSentence("link.full") };
    // A page whose turn is near is connecting already.
    if (!this.#isVisiting) this.#askIn(pauseMs);
    this.#tellLink();
  }

  #told({ server_ms, watching, room }: Told): void {
    const nowMs = performance.now();
    this.#clock.add(server_ms, nowMs);
    this.#silence.heard(nowMs);
    if (this.#isServed) return;
    const isThere = room.viewers.some((one) => one.id === this.#number);
    if (!isThere && nowMs - this.#askedMs > TOLD_LATE_MS) this.#number = null;
    this.options.state.watching.value = watching;
    this.#enter(room);
  }

  // --- the queue -----------------------------------------------------------------------------

  async #post(wants: Wants): Promise<void> {
    this.#askedMs = performance.now();
    const { name } = this.options.state.preferences.peek();
    const line = await postQueue(this.options.client(), wants, name);
    const room = this.options.state.room.peek();
    if (this.#isServed || !room) return;
    this.#number = line.role === "observer" ? null : line.id;
    const others = room.viewers.filter((one) => one.id !== line.id && one.id !== 0);
    this.#enter({ ...room, viewers: this.#number === null ? others : [...others, line] });
  }

  #enter(room: RoomState): void {
    const { state, enterRoom } = this.options;
    const id = this.#number ?? 0;
    const hello = state.hello.peek();
    if (hello && hello.viewer !== id) state.hello.value = { ...hello, viewer: id };
    enterRoom(withMe(room, id, state.preferences.peek().name || t("link.guest")));
    const me = state.me.peek();
    if (me) this.#visit(room, me);
  }

  // --- to the robot's server and back --------------------------------------------------------

  #visit(room: RoomState, me: ViewerInfo): void {
    const must = mustCome(room, me);
    if (must === this.#isVisiting) return;
    this.#isVisiting = must;
    if (must) {
      clearTimeout(this.#asking);
      this.options.link.connect();
    } else {
      this.options.link.close();
      this.#renewIn(RENEW_SOON_MS);
    }
  }

  /** Schedules a connection to the robot's server, for a place or other rooms: no room plays. */
  #askIn(ms: number): void {
    clearTimeout(this.#asking);
    this.#asking = setTimeout(() => this.options.link.connect(), ms);
  }

  /** Schedules a request for fresh tokens, which costs the server next to nothing. */
  #renewIn(ms: number): void {
    clearTimeout(this.#asking);
    this.#asking = setTimeout(() => void this.#renew(), ms);
  }

  async #renew(): Promise<void> {
    const where = await postSeat(this.options.client()).catch((error: unknown) => error);
    if (this.#isServed || this.#isVisiting) return;
    if (!(where instanceof Error)) this.sent(where as Sent);
    else if (where instanceof RequestError && where.ended)
      this.options.link.connect(); // its answer says why
    else this.#renewIn(AGAIN_MS * (1 + Math.random()));
  }

  /** Shows the server's picture once it has arrived, and rests or leaves the room. */
  #arrive(): void {
    if (!this.#arriving) return;
    const { state, wants } = this.options;
    const { picture, show } = this.#arriving;
    const isWaited = wants().picture && isPictureExpected(state.room.peek()) && this.isOnScreen;
    const hasCome = picture.getSynchronizationSources().length > 0;
    if (isWaited && !hasCome && state.drivingTurn.peek() === null) return;
    this.#arriving = null;
    this.#onScreen = "server";
    this.#inStep.setReceivers(null);
    if (this.#isVisiting) this.#watch.rest();
    else this.#watch.leave();
    show();
  }

  /** Resumes the room after the turn. */
  #return(nowMs: number): void {
    const { state } = this.options;
    const [room, me] = [state.room.peek(), state.me.peek()];
    const isVisitor = this.#isServed && this.#isVisiting && this.#onScreen === "server";
    if (!isVisitor || this.#link.is !== "connected" || !room || !me) return;
    if (!this.#watch.hasRoom) {
      // The room ended meanwhile: the page has a place at the server, and stays.
      this.#isVisiting = false;
    } else if (!this.#isReturning && mayGo(room, me)) {
      this.#isReturning = true;
      this.#watch.resume(nowMs);
    } else if (this.#isReturning && mustCome(room, me)) {
      this.#isReturning = false;
      this.#watch.rest();
    }
  }

  /** Gives the place at the server back once the room's picture has arrived. */
  #leaveServer(): void {
    const { state, link } = this.options;
    const me = state.me.peek();
    const room = state.room.peek();
    this.#isServed = this.#isVisiting = this.#isReturning = false;
    this.#number = me?.role === "queued" ? me.id : null;
    state.isInRoom.value = true;
    state.served.value = null;
    const kept = this.#number === null ? Promise.resolve() : this.#post("stay");
    void kept
      .catch(() => {})
      .then(() => {
        if (!this.#isVisiting) link.close();
      });
    this.#renewIn(RENEW_SOON_MS);
    if (room) {
      const isGone = (one: ViewerInfo) => one.id === me?.id && this.#number === null;
      this.#enter({ ...room, viewers: room.viewers.filter((one) => !isGone(one)) });
    }
  }

  #tellLink(): void {
    const { state } = this.options;
    const isTold = this.#isServed || (this.#roomLink.is !== "connected" && hasReason(this.#link));
    state.link.value = isTold ? this.#link : this.#played();
  }

  #played(): LinkState {
    const isSilent = this.#isSilent && this.#roomLink.is === "connected";
    return isSilent ? { is: "silent", sinceMs: this.#silence.sinceMs } : this.#roomLink;
  }
}

/** Whether the link says why there is no connection. */
function hasReason(link: LinkState): boolean {
  return link.is === "waiting" || (link.is === "connecting" && link.reason !== null);
}

/** Whether there is a picture to wait for. */
function isPictureExpected(room: RoomState | null): boolean {
  return room === null || room.video.problem === null;
}
