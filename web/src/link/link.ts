import { ServerClock } from "../clock";
import type { Channel, DriveIn, StateIn, StateOut } from "../messages";
import { Heartbeat } from "./heartbeat";
import { Peer } from "./peer";
import { retryDelayMs } from "./reconnect";
import { readRow, writeRow } from "./rows";
import { Silence } from "./silence";

/**
 * The state of the connection; `silent` means that nothing has arrived recently. Times are on the
 * page's clock; reasons are sentences.
 */
export type LinkState =
  | { is: "connecting" }
  | { is: "connected" }
  | { is: "silent"; sinceMs: number }
  | { is: "waiting"; retryAtMs: number; reason: string }
  | { is: "closed" };

/** The link's events. */
export interface LinkEvents {
  changed(state: LinkState): void;
  /** A new peer is being connected; measurements of the previous one are no longer valid. */
  fresh(peer: Peer): void;
  received(message: StateOut): void;
  /** Called only at the moment when a peer's receivers are created. */
  receivers(sound: RTCRtpReceiver, picture: RTCRtpReceiver): void;
}

const CONNECT_MS = 10_000;
/** A connection that breaks sooner than this counts as a failed attempt. */
const STEADY_MS = 5000;
const LOOK_EVERY_MS = 100;
/** After a goodbye: no restart is faster, and not everybody comes back at the same instant. */
const GOODBYE_MS = 1000;

const now = () => performance.now();

/** Keeps a connection to the server, with one peer after another, while the page is open. */
export class Link {
  clock = new ServerClock();
  /** This page drives or waits to drive, so its silence must be noticed soon. */
  mayDrive = false;
  /** The link is so slow that every datagram counts: it gets only one ping a second. */
  isThin = false;
  #heartbeat = new Heartbeat(this.clock);
  #silence = new Silence(now());
  #peer: Peer | null = null;
  #failures = 0;
  #connectedMs = Number.POSITIVE_INFINITY;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #looking: ReturnType<typeof setInterval> | undefined;
  #state: LinkState = { is: "closed" };

  constructor(
    private readonly client: () => string,
    private readonly events: LinkEvents,
  ) {}

  get peer(): Peer | null {
    return this.#peer;
  }

  /** Connects at once, whatever the state. */
  connect(): void {
    this.#drop();
    this.clock = new ServerClock();
    this.#heartbeat = new Heartbeat(this.clock);
    this.isThin = false;
    const peer = new Peer({
      opened: () => this.#opened(),
      received: (channel, text) => this.#received(channel, text),
      lost: (reason) => this.#lost(reason),
      receivers: this.events.receivers,
    });
    this.#peer = peer;
    this.#change({ is: "connecting" });
    this.events.fresh(peer);
    this.#timer = setTimeout(() => this.#lost("The server does not answer."), CONNECT_MS);
    void peer.connect(this.client());
  }

  /** Makes a pending next attempt now. */
  hurry(): void {
    if (this.#state.is === "waiting") this.connect();
  }

  /** Closes until `connect` is called again. */
  close(): void {
    this.#drop();
    this.#change({ is: "closed" });
  }

  /** Sends what is worthless when late; `urgent` is sent even behind a backlog. */
  sendDrive(message: DriveIn, urgent = false): void {
    this.#peer?.send("drive", writeRow(message), urgent);
  }

  /**
   * Sends what must arrive. Returns false without a connection: nothing is kept for later.
   */
  sendState(message: StateIn): boolean {
    return this.#peer?.send("state", JSON.stringify(message)) ?? false;
  }

  /** Counts anything from the server, including a picture, as a sign of life. */
  heard(): void {
    this.#silence.heard(now());
    if (this.#state.is === "silent") this.#change({ is: "connected" });
  }

  #opened(): void {
    this.#silence = new Silence(now());
    this.#looking = setInterval(() => this.#look(), LOOK_EVERY_MS);
    this.#beat();
  }

  #look(): void {
    const silence = this.#silence;
    const wasDoubtful = silence.isDoubtful;
    silence.look(now());
    if (silence.isDoubtful && !wasDoubtful && !this.isThin) this.#beat();
    const unansweredMs = this.#heartbeat.unansweredMs(now());
    const isSilent = silence.isSilent(unansweredMs, this.clock.slowestMs ?? 0, this.isThin);
    if (isSilent && this.#state.is === "connected") {
      this.#change({ is: "silent", sinceMs: silence.sinceMs });
    }
  }

  #beat(): void {
    if (this.#heartbeat.isSilent(now())) {
      this.#lost("The server has gone silent.");
      return;
    }
    this.sendDrive(this.#heartbeat.beat(now()));
    clearTimeout(this.#timer);
    // Over a slow link the set-points already show that this page is alive.
    const isKeen = (this.mayDrive || this.#silence.isDoubtful) && !this.isThin;
    this.#timer = setTimeout(() => this.#beat(), this.#heartbeat.pauseMs(now(), isKeen));
  }

  #received(channel: Channel, text: string): void {
    this.heard();
    if (channel === "drive") {
      this.#heartbeat.heard(readRow(text), now());
      return;
    }
    const message = JSON.parse(text) as StateOut;
    // First, so that listeners to the new connection do not see the previous one's room.
    this.events.received(message);
    if (message.type === "hello") {
      this.#connectedMs = now();
      this.#change({ is: "connected" });
    } else if (message.type === "goodbye") {
      this.#lost(message.text, GOODBYE_MS * (1 + Math.random()));
    }
  }

  #lost(reason: string, leastMs = 0): void {
    this.#drop();
    if (now() - this.#connectedMs >= STEADY_MS) this.#failures = 0;
    this.#connectedMs = Number.POSITIVE_INFINITY;
    const pauseMs = Math.max(leastMs, retryDelayMs(this.#failures++, Math.random()));
    this.#change({ is: "waiting", retryAtMs: now() + pauseMs, reason });
    this.#timer = setTimeout(() => this.connect(), pauseMs);
  }

  #drop(): void {
    clearTimeout(this.#timer);
    clearInterval(this.#looking);
    this.#peer?.close();
    this.#peer = null;
  }

  #change(state: LinkState): void {
    this.#state = state;
    this.events.changed(state);
  }
}
