import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { StateOut } from "../messages";
import { hello } from "../testing/messages";
import { Link, type LinkState } from "./link";
import type { PeerEvents } from "./peer";

/** What is looked at of what went over the drive channel. */
interface DrivePing {
  type: string;
  id: number;
  sentMs: number;
}

const { FakePeer, peers } = vi.hoisted(() => {
  const made: InstanceType<typeof Fake>[] = [];

  /** Stands where the browser's peer connection would: what it hears is told by the test. */
  class Fake {
    sent: DrivePing[] = [];
    isClosed = false;

    constructor(readonly events: PeerEvents) {
      made.push(this);
    }

    async connect(): Promise<void> {}

    send(_channel: string, text: string): void {
      const [type, id, sentMs] = JSON.parse(text);
      this.sent.push({ type, id, sentMs });
    }

    close(): void {
      this.isClosed = true;
    }
  }

  return { FakePeer: Fake, peers: made };
});

vi.mock("./peer", () => ({ Peer: FakePeer }));

let link: Link;
let states: LinkState[];
let heard: StateOut[];

beforeEach(() => {
  vi.useFakeTimers({
    toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"],
  });
  vi.spyOn(Math, "random").mockReturnValue(0);
  peers.length = 0;
  states = [];
  heard = [];
  link = new Link(() => "client", {
    changed: (state) => states.push(state),
    fresh: () => {},
    received: (message) => heard.push(message),
    receivers: () => {},
  });
  link.connect();
});

afterEach(() => {
  link.close();
  vi.useRealTimers();
});

function peer() {
  const newest = peers.at(-1);
  if (!newest) throw new Error("there is no peer");
  return newest;
}

/** Both channels open, and the server greets. */
function open(): void {
  peer().events.opened();
  peer().events.received("state", JSON.stringify(hello()));
}

/** The server answers the newest ping. */
function pong(): void {
  const ping = peer().sent.findLast((message) => message.type === "ping");
  if (!ping) throw new Error("there was no ping");
  const answer = ["pong", ping.id, ping.sentMs, ping.sentMs + 5000];
  peer().events.received("drive", JSON.stringify(answer));
}

/** Lets time pass with an answer to every ping. */
function answerFor(seconds: number): void {
  for (let tenth = 0; tenth < seconds * 10; tenth++) {
    vi.advanceTimersByTime(100);
    pong();
  }
}

it("is connected when the server has greeted, and passes its messages on", () => {
  expect(states.at(-1)).toEqual({ is: "connecting" });
  open();
  expect(states.at(-1)).toEqual({ is: "connected" });
  expect(heard[0]?.type).toBe("hello");
});

it("aligns the clock by its heartbeat", () => {
  open();
  pong();
  expect(link.clock.toServerMs(performance.now())).toBeCloseTo(performance.now() + 5000);
});

it("pings five times a second while it may drive, over a slow link once", () => {
  const pingsIn = (seconds: number) => {
    const before = peer().sent.length;
    answerFor(seconds);
    return peer().sent.length - before;
  };
  link.mayDrive = true;
  open();
  answerFor(2);
  expect(pingsIn(10)).toBeGreaterThanOrEqual(49);
  link.isThin = true;
  answerFor(1);
  expect(pingsIn(10)).toBe(10);
  link.connect();
  expect(link.isThin).toBe(false);
});

it("comes back with a fresh peer, at once first, then ever later, saying why", () => {
  const waits: number[] = [];
  for (let attempt = 0; attempt < 5; attempt++) {
    const count = peers.length;
    peer().events.lost("The server is full.");
    const state = states.at(-1);
    if (state?.is !== "waiting") throw new Error("it does not wait");
    expect(state.reason).toBe("The server is full.");
    waits.push(Math.round(state.retryAtMs - performance.now()));
    vi.advanceTimersByTime(waits.at(-1) ?? 0);
    expect(peers).toHaveLength(count + 1);
  }
  expect(waits).toEqual([0, 300, 1200, 2700, 4800]);
  expect(peers.slice(0, -1).every((old) => old.isClosed)).toBe(true);
});

it("takes a connection that breaks at once for one more failure, a steady one for none", () => {
  const waitMs = () => {
    const state = states.at(-1);
    return state?.is === "waiting" ? Math.round(state.retryAtMs - performance.now()) : null;
  };
  peer().events.lost("");
  vi.advanceTimersByTime(0);
  open();
  peer().events.lost("");
  expect(waitMs()).toBe(300);
  vi.advanceTimersByTime(300);
  open();
  answerFor(6);
  peer().events.lost("");
  expect(waitMs()).toBe(0);
});

it.each([
  [0, 1000],
  [0.999, 1999],
])("waits a moment of its own after a goodbye (random %d)", (random, waitMs) => {
  open();
  answerFor(6);
  vi.mocked(Math.random).mockReturnValue(random);
  const text = "The server is restarting or was switched off.";
  peer().events.received("state", JSON.stringify({ type: "goodbye", text }));
  expect(states.at(-1)).toEqual({
    is: "waiting",
    retryAtMs: performance.now() + waitMs,
    reason: text,
  });
  expect(peer().isClosed).toBe(true);
  vi.advanceTimersByTime(waitMs);
  expect(peers).toHaveLength(2);
});

it("gives up a peer that has been silent for three seconds", () => {
  link.mayDrive = true;
  open();
  answerFor(2);
  const before = peers.length;
  vi.advanceTimersByTime(2700);
  expect(peers).toHaveLength(before);
  vi.advanceTimersByTime(700);
  expect(peers).toHaveLength(before + 1);
  expect(peers[before - 1]?.isClosed).toBe(true);
});

it("gives up an attempt that comes to nothing", () => {
  vi.advanceTimersByTime(9999);
  expect(peers).toHaveLength(1);
  vi.advanceTimersByTime(2);
  expect(peers).toHaveLength(2);
});

it("hurries only where it waits", () => {
  link.hurry();
  expect(peers).toHaveLength(1);
  peer().events.lost("");
  vi.advanceTimersByTime(0);
  peer().events.lost("");
  link.hurry();
  expect(peers).toHaveLength(3);
  vi.advanceTimersByTime(1000);
  expect(peers).toHaveLength(3);
});

it("stays closed once closed, until it is told to connect", () => {
  open();
  link.close();
  vi.advanceTimersByTime(60_000);
  expect(peers).toHaveLength(1);
  expect(peer().isClosed).toBe(true);
  link.connect();
  expect(peers).toHaveLength(2);
});

/** Nothing comes any more, for so long. */
function fallSilentFor(seconds: number): void {
  vi.advanceTimersByTime(seconds * 1000);
}

/** Thirty pictures a second come, and an answer to every ping with the next of them. */
function playFor(seconds: number): void {
  let answered = peer().sent.length;
  for (let frame = 0; frame < seconds * 30; frame++) {
    vi.advanceTimersByTime(1000 / 30);
    link.heard();
    if (peer().sent.length > answered) pong();
    answered = peer().sent.length;
  }
}

it.each([true, false])("says within a second that no answer comes, driving: %s", (mayDrive) => {
  link.mayDrive = mayDrive;
  open();
  for (let tenth = 0; tenth < 10; tenth++) {
    playFor(6 + tenth / 10);
    const heardMs = performance.now();
    fallSilentFor(0.9);
    expect(states.at(-1)).toEqual({ is: "silent", sinceMs: heardMs });
    link.heard();
    expect(states.at(-1)).toEqual({ is: "connected" });
  }
});

it("tells of one silence once, then that the connection is lost", () => {
  open();
  answerFor(2);
  const before = states.length;
  fallSilentFor(3.6);
  expect(states.slice(before).map((state) => state.is)).toEqual([
    "silent",
    "waiting",
    "connecting",
  ]);
});

it("takes a picture, and a message of any kind, for an answer", () => {
  open();
  answerFor(2);
  fallSilentFor(1);
  link.heard();
  expect(states.at(-1)).toEqual({ is: "connected" });
  fallSilentFor(1);
  expect(states.at(-1)?.is).toBe("silent");
  peer().events.received("state", JSON.stringify({ type: "notice", text: "" }));
  expect(states.at(-1)).toEqual({ is: "connected" });
});

it("asks in between only where nothing comes", () => {
  open();
  playFor(2);
  const before = peer().sent.length;
  playFor(5);
  expect(peer().sent.length - before).toBe(5);
  fallSilentFor(0.65);
  expect(peer().sent.length - before).toBe(7);
});

it("waits for an answer as long as answers take on this link", () => {
  open();
  answerFor(2);
  // A satellite: every answer takes 800 ms, and there is no picture.
  const answers: { atMs: number; text: string }[] = [];
  let seen = peer().sent.length;
  const before = states.length;
  const satelliteFor = (seconds: number) => {
    for (let step = 0; step < seconds * 50; step++) {
      vi.advanceTimersByTime(20);
      for (const ping of peer().sent.slice(seen)) {
        const text = JSON.stringify(["pong", ping.id, ping.sentMs, ping.sentMs + 5000]);
        answers.push({ atMs: performance.now() + 800, text });
      }
      seen = peer().sent.length;
      while (answers[0] && answers[0].atMs <= performance.now()) {
        peer().events.received("drive", answers.shift()?.text ?? "");
      }
    }
  };
  satelliteFor(3);
  const settled = states.length;
  expect(settled - before).toBeLessThanOrEqual(2); // the first answer is late, once
  satelliteFor(30);
  expect(states).toHaveLength(settled);
});

it("lets a slow link stall for a second", () => {
  open();
  answerFor(2);
  link.isThin = true;
  const before = states.length;
  for (let stall = 0; stall < 10; stall++) {
    answerFor(2);
    fallSilentFor(1.2);
  }
  answerFor(0.1);
  expect(states).toHaveLength(before);
  fallSilentFor(2);
  expect(states.at(-1)?.is).toBe("silent");
});

it("says nothing of a silence before the server has greeted", () => {
  peer().events.opened();
  fallSilentFor(2);
  expect(states).toEqual([{ is: "connecting" }]);
});
