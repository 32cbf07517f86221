/** When one peer replaces another; how long to wait: `reconnect.ts`; one peer: `peer.ts`. */

import type { Channel, DriveIn, Ended, Operated, Pong, StateIn, StateOut } from "../messages";
import { ServerClock } from "../serverClock";
import { pageSentence, type Saying } from "../words/said";
import { Heartbeat } from "./heartbeat";
import { Peer, type PeerEvents } from "./peer";
import { attemptAfterMs, freshMs, type LostLink, patienceMs } from "./reconnect";
import { readRow, writeRow } from "./rows";
import type { Sent } from "./signalling";
import { Silence } from "./silence";

/**
 * The state of the connection; `silent` means that nothing has arrived recently, `waiting` that the
 * next attempt begins later. Times are on the page's clock; a reason says why the previous attempt
 * or connection ended, null if there was none.
 */
export type LinkState =
  | { is: "connecting"; reason: Saying | null }
  | { is: "connected" }
  | { is: "silent"; sinceMs: number }
  | { is: "waiting"; retryAtMs: number; reason: Saying }
  | { is: "closed" };

/** The link's events. */
export interface LinkEvents {
  changed(state: LinkState): void;
  /** A peer's offer was sent. */
  offered(): void;
  /** A new peer replaces the previous one, whose measurements are no longer valid. */
  fresh(peer: Peer): void;
  received(message: StateOut): void;
  /** The server has answered a command to the robot's controls. */
  operated(answer: Operated): void;
  /** Called only at the moment when a peer's receivers are created. */
  receivers(sound: RTCRtpReceiver, picture: RTCRtpReceiver): void;
  /** The link has closed: the server is full, and names LiveKit rooms instead. */
  sent(where: Sent): void;
}

const OPEN_MS = 4000;
/** A connection that breaks sooner than this does not reset the count of attempts. */
const STEADY_MS = 5000;
const LOOK_EVERY_MS = 100;
/** A shorter pause is not worth a countdown. */
const SHOWN_PAUSE_MS = 1500;
/** The longest wait that the server can ask for. */
const MAX_RETRY_AFTER_MS = 300_000;
/** The least pause after a goodbye; no restart is faster. Up to twice it, to spread pages. */
const GOODBYE_MS = 1000;
/** How long a peer that may be alive has to answer after a change of network. */
const DOUBT_MS = 150;
/** Likewise for a peer that can continue from another address, which the server checks first. */
const MOVE_MS = 300;
/** How often it pings meanwhile: pings before the browser has the new route are lost. */
const MOVING_EVERY_MS = 50;
/** The most allowed for the old network's delay: one that is being left is often slow. */
const MOST_DELAY_MS = 1000;

const now = () => performance.now();

/**
 * Keeps a connection to the server, with one peer after another, while the page is open.
 *
 * A peer that has fallen silent is kept until the server has answered another one, because it is
 * often the first to notice that the network is back. It continues if the browser reported another
 * network, since the server then follows it to the new address and starts over, or if a thin link
 * was only slow. Otherwise another peer replaces it: for the old one's pictures the server would
 * have to find out, slowly, what the link carries now.
 */
export class Link {
  clock = new ServerClock();
  /** Whether this page drives or waits to drive, so that its silence must be noticed soon. */
  mayDrive = false;
  /** Whether the link is so slow that every datagram counts: it gets only one ping a second. */
  isThin = false;
  /** Whether the server accepts voices; set before the first connection. */
  mayHaveVoice = false;
  /** The number of cameras other than the driving view; set before the first connection. */
  cameras = 0;
  #heartbeat = new Heartbeat(this.clock);
  #silence = new Silence(now());
  /** The newest peer that the server has answered. */
  #peer: Peer | null = null;
  /** The peer that is being tried as a replacement. */
  #next: Peer | null = null;
  #isRetrying = false;
  /** Whether the peer has time to continue on another network; meanwhile no other is offered. */
  #isMoving = false;
  /** Whether a sign of life lets the peer continue there; true until another is offered. */
  #mayGoOn = false;
  /** Whether the current attempt has reached the server. */
  #isReached = false;
  #attempts = 0;
  #begunMs = 0;
  #notBeforeMs = 0;
  #lostLink: LostLink | null = null;
  /** When the server's hello arrived; infinite before. */
  #connectedMs = Number.POSITIVE_INFINITY;
  #trying: ReturnType<typeof setTimeout> | undefined;
  #beating: ReturnType<typeof setTimeout> | undefined;
  #looking: ReturnType<typeof setInterval> | undefined;
  #state: LinkState = { is: "closed" };

  constructor(
    private readonly client: () => string,
    private readonly events: LinkEvents,
  ) {}

  get peer(): Peer | null {
    return this.#peer;
  }

  /** The newest beat received, to be named in commands; null before the first. */
  get beat(): string | null {
    return this.#heartbeat.newestBeat;
  }

  /** Connects at once, whatever the state. */
  connect(): void {
    this.#drop();
    this.#attempts = 0;
    this.#notBeforeMs = 0;
    this.#begin(null);
  }

  /** Starts a pending attempt now, unless the server asked to wait. */
  hurry(): void {
    if (this.#state.is === "waiting" && now() >= this.#notBeforeMs) this.#begin(this.#state.reason);
  }

  /**
   * Handles a possible change of network. Pings the peer to see whether it still works; if that is
   * doubtful, prepares another meanwhile. Many reported changes are none.
   */
  networkChanged(): void {
    if (this.#state.is === "closed" || now() < this.#notBeforeMs || this.#isMoving) return;
    const isAlive = this.#state.is === "connected" && !this.#silence.isDoubtful;
    const mayMove = this.#isGreeted && this.#peer?.mayMove === true;
    if (!isAlive && !mayMove) {
      this.#attempts = 0;
      this.#begin(null);
      return;
    }
    const slowestMs = this.clock.slowestMs ?? 0;
    const answerMs = mayMove
      ? MOVE_MS + Math.min(2 * slowestMs, MOST_DELAY_MS)
      : DOUBT_MS + slowestMs;
    const askedMs = now();
    this.#isMoving = this.#mayGoOn = mayMove;
    this.#ping();
    const asking =
      mayMove && !this.isThin ? setInterval(() => this.#ping(), MOVING_EVERY_MS) : undefined;
    const asked = new Promise<void>((resolve) => {
      setTimeout(() => {
        clearInterval(asking);
        this.#isMoving = false;
        const isHeard = this.#silence.sinceMs > askedMs;
        if (!isHeard && this.#peer && !this.#isRetrying) this.#lose(pageSentence("link.silent"));
        resolve();
      }, answerMs);
    });
    if (isAlive) return;
    this.#attempts = 0;
    this.#begin(null, asked, answerMs);
  }

  /** Closes until `connect` is called again. */
  close(): void {
    this.#drop();
    this.#change({ is: "closed" });
  }

  /** Sends over the unreliable channel; `urgent` messages even behind a backlog. */
  sendDrive(message: DriveIn, urgent = false): void {
    // Unacknowledged, SCTP soon takes no more for a second, not even the ping that finds the server
    // again. Loopback works without a network, but is not silent then.
    const isLost = navigator.onLine === false && this.#silence.isDoubtful;
    if (isLost && !urgent && message.type !== "ping") return;
    this.#peer?.send("drive", writeRow(message), urgent);
  }

  /**
   * Sends over the reliable channel. Returns false without a connection: nothing is queued.
   */
  sendState(message: StateIn): boolean {
    return this.#peer?.send("state", JSON.stringify(message)) ?? false;
  }

  /** Counts anything from the server, including a picture, as a sign of life. */
  heard(): void {
    this.#silence.heard(now());
    if (this.#state.is === "silent") this.#change({ is: "connected" });
    if (this.#mayGoOn && this.#isRetrying && this.#isGreeted) this.#resume();
  }

  // --- attempts ------------------------------------------------------------------------------

  /** Starts an attempt, in place of any previous one that was not answered. */
  #begin(reason: Saying | null, mayOffer?: Promise<void>, afterMs = 0): void {
    clearTimeout(this.#trying);
    this.#next?.close();
    const events: PeerEvents = {
      reached: () => this.#reached(),
      offered: () => {
        this.#mayGoOn = false;
        this.events.offered();
      },
      answered: () => this.#adopt(peer),
      opened: () => this.#opened(),
      received: (channel, text) => this.#received(channel, text),
      lost: (why, retryAfterMs) => this.#lostPeer(peer, why, retryAfterMs),
      refused: (ended) => this.#end(ended),
      sent: (where) => {
        this.close();
        this.events.sent(where);
      },
      receivers: this.events.receivers,
    };
    const peer: Peer = new Peer(events, this.mayHaveVoice, this.cameras);
    this.#next = peer;
    this.#isRetrying = true;
    this.#isReached = false;
    this.#begunMs = now();
    this.#attempts++;
    this.#change({ is: "connecting", reason });
    const forMs = patienceMs(attemptAfterMs(this.#attempts, Math.random()), this.#lostLink);
    this.#giveUpAfter(afterMs + forMs);
    void peer.connect(this.client(), mayOffer);
  }

  /** Continues with the old peer, which works again, and drops the attempt. */
  #resume(): void {
    clearTimeout(this.#trying);
    this.#next?.close();
    this.#next = null;
    this.#isRetrying = this.#mayGoOn = false;
    this.#heartbeat.forgetUnanswered();
    this.#change({ is: "connected" });
  }

  #reached(): void {
    this.#isReached = true;
    this.#giveUpAfter(patienceMs(OPEN_MS, this.#lostLink));
  }

  /** Replaces the old peer by this one: the server has accepted it, and dropped the old one. */
  #adopt(peer: Peer): void {
    this.#forget();
    this.#next = null;
    this.#peer = peer;
    this.clock = new ServerClock();
    this.#heartbeat = new Heartbeat(this.clock);
    this.isThin = false;
    this.events.fresh(peer);
    this.#giveUpAfter(patienceMs(OPEN_MS, this.#lostLink));
  }

  /** Starts another attempt unless this one gets further within this time. */
  #giveUpAfter(ms: number): void {
    clearTimeout(this.#trying);
    this.#trying = setTimeout(() => {
      const tried = this.#next ?? this.#peer;
      this.#begin(tried?.trouble ?? pageSentence("link.no_answer"));
    }, ms);
  }

  /** Closes: this page may not join, and does not retry by itself. */
  #end(ended: Ended): void {
    this.events.received(ended);
    this.close();
  }

  #lostPeer(peer: Peer, reason: Saying, retryAfterMs: number | null): void {
    if (peer === this.#next) {
      this.#next = null;
      const askedMs = Math.min(retryAfterMs ?? 0, MAX_RETRY_AFTER_MS);
      // Spread the retries of many pages.
      this.#retry(reason, askedMs * (1 + Math.random() / 5));
      return;
    }
    // A replacement for a peer that had fallen silent may be under way already.
    const isReplaced = this.#next !== null || (this.#isRetrying && this.#isGreeted);
    if (!isReplaced) this.#lose(reason);
    this.#forget();
  }

  /** Starts to try other peers; keeps the old one, which may recover. */
  #lose(reason: Saying): void {
    const { rttMs } = this.clock;
    if (rttMs !== null) this.#lostLink = { roundTripMs: rttMs, isThin: this.isThin };
    if (now() - this.#connectedMs >= STEADY_MS) this.#attempts = 0;
    this.#retry(reason, 0);
  }

  /** Schedules the next attempt, no sooner than in `leastMs`, whatever happens meanwhile. */
  #retry(reason: Saying, leastMs: number): void {
    clearTimeout(this.#trying);
    this.#isRetrying = true;
    this.#notBeforeMs = now() + leastMs;
    const nextMs = this.#begunMs + attemptAfterMs(this.#attempts, Math.random());
    const atMs = Math.max(nextMs, this.#notBeforeMs);
    const pauseMs = atMs - now();
    if (pauseMs <= 0) {
      this.#begin(reason);
      return;
    }
    const isShort = pauseMs < SHOWN_PAUSE_MS;
    this.#change(
      isShort ? { is: "connecting", reason } : { is: "waiting", retryAtMs: atMs, reason },
    );
    this.#trying = setTimeout(() => this.#begin(reason), pauseMs);
  }

  /** Restarts an attempt that was sent into a dead network, unless the server has answered. */
  #tryNow(): void {
    const isOld = now() - this.#begunMs >= freshMs(this.isThin);
    if (isOld && !this.#isReached && now() >= this.#notBeforeMs)
      this.#begin(pageSentence("link.no_answer"));
  }

  get #isGreeted(): boolean {
    return this.#connectedMs < Number.POSITIVE_INFINITY;
  }

  // --- the peer's life -----------------------------------------------------------------------

  #opened(): void {
    this.#silence = new Silence(now());
    this.#looking = setInterval(() => this.#checkSilence(), LOOK_EVERY_MS);
    this.#beat();
  }

  #checkSilence(): void {
    const silence = this.#silence;
    const wasDoubtful = silence.isDoubtful;
    silence.update(now());
    if (silence.isDoubtful && !wasDoubtful && !this.isThin) this.#beat();
    const unansweredMs = this.#heartbeat.unansweredMs(now());
    const isSilent = silence.isSilent(unansweredMs, this.clock.slowestMs ?? 0, this.isThin);
    if (isSilent && this.#state.is === "connected") {
      this.#change({ is: "silent", sinceMs: silence.sinceMs });
    }
  }

  #beat(): void {
    // A modem's link stalls for a second now and then.
    const isUrgent = this.mayDrive && !this.isThin;
    if (this.#heartbeat.isSilent(now(), isUrgent) && !this.#isRetrying)
      this.#lose(pageSentence("link.silent"));
    this.#ping();
    clearTimeout(this.#beating);
    // Over a slow link the set-points already show that this page is alive.
    const isKeen = (this.mayDrive || this.#silence.isDoubtful) && !this.isThin;
    this.#beating = setTimeout(() => this.#beat(), this.#heartbeat.pauseMs(now(), isKeen));
  }

  #ping(): void {
    this.sendDrive(this.#heartbeat.nextPing(now()));
  }

  #received(channel: Channel, text: string): void {
    this.heard();
    if (this.#isRetrying && this.#isGreeted) this.#tryNow();
    if (channel === "drive") {
      const answer = readRow(text);
      if (answer.type === "pong") this.#answered(answer);
      else if (answer.type === "beat") this.#heartbeat.storeBeat(answer.beat);
      else this.events.operated(answer);
      return;
    }
    const message = JSON.parse(text) as StateOut;
    // First, so that listeners to the new connection do not see the previous one's room state.
    this.events.received(message);
    if (message.type === "hello") {
      clearTimeout(this.#trying);
      this.#next?.close();
      this.#next = null;
      this.#isRetrying = false;
      this.#connectedMs = now();
      this.#change({ is: "connected" });
    } else if (message.type === "ended") {
      this.close();
    } else if (message.type === "goodbye") {
      this.#forget();
      this.#attempts = 0;
      this.#retry(message.text, GOODBYE_MS * (1 + Math.random()));
    }
  }

  #answered(pong: Pong): void {
    this.#heartbeat.handlePong(pong, now());
    // The thin link was only slow, and a new peer would cost it some seconds.
    if (this.#isRetrying && this.#isGreeted && this.isThin && !this.#isReached) this.#resume();
  }

  #drop(): void {
    clearTimeout(this.#trying);
    this.#next?.close();
    this.#next = null;
    this.#forget();
  }

  #forget(): void {
    clearTimeout(this.#beating);
    clearInterval(this.#looking);
    this.#peer?.close();
    this.#peer = null;
    this.#mayGoOn = false;
    this.#connectedMs = Number.POSITIVE_INFINITY;
  }

  #change(state: LinkState): void {
    this.#state = state;
    this.events.changed(state);
  }
}
