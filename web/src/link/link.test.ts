import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { DriveIn, Ended, Operated, StateOut } from "../messages";
import { hello, sentToRoom } from "../testing/messages";
import { type Saying, says } from "../words/said";
import { Link, type LinkState } from "./link";
import type { PeerEvents } from "./peer";
import type { Sent } from "./signalling";

/** The parts of drive messages that the tests check. */
interface DrivePing {
  type: string;
  id: number;
  sentMs: number;
}

const { FakePeer, peers } = vi.hoisted(() => {
  const made: InstanceType<typeof Fake>[] = [];

  /** Replaces the browser's peer connection; the test says what it receives. */
  class Fake {
    sent: DrivePing[] = [];
    isClosed = false;
    trouble: Saying = { code: "link.no_answer" };
    mayMove = false;
    mayOffer = true;

    constructor(readonly events: PeerEvents) {
      made.push(this);
    }

    async connect(_client: string, mayOffer?: Promise<void>): Promise<void> {
      this.mayOffer = mayOffer === undefined;
      await mayOffer;
      this.mayOffer = true;
    }

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
let answers: Operated[];
let sentTo: Sent[];

beforeEach(() => {
  vi.useFakeTimers({
    toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"],
  });
  vi.spyOn(Math, "random").mockReturnValue(0.5);
  peers.length = 0;
  states = [];
  heard = [];
  answers = [];
  sentTo = [];
  link = new Link(() => "client", {
    changed: (state) => states.push(state),
    fresh: () => {},
    received: (message) => heard.push(message),
    operated: (answer) => answers.push(answer),
    offered: () => {},
    receivers: () => {},
    sent: (where) => sentTo.push(where),
  });
  link.connect();
});

afterEach(() => {
  link.close();
  vi.unstubAllGlobals();
});

function peer() {
  const newest = peers.at(-1);
  if (!newest) throw new Error("there is no peer");
  return newest;
}

/** The server answers, both channels open, and its hello arrives. */
function open(): void {
  peer().events.reached();
  peer().events.answered();
  greet();
}

/** Both channels open, and the server's hello arrives. */
function greet(): void {
  peer().events.opened();
  peer().events.received("state", JSON.stringify(hello()));
}

/** The server answers the newest ping. */
function pong(): void {
  const ping = peer().sent.findLast((message) => message.type === "ping");
  if (!ping) throw new Error("there was no ping");
  const answer = ["pong", ping.id, ping.sentMs, ping.sentMs + 5000, "x7-_2A"];
  peer().events.received("drive", JSON.stringify(answer));
}

/** Advances time with an answer to every ping. */
function answerFor(seconds: number): void {
  for (let tenth = 0; tenth < seconds * 10; tenth++) {
    vi.advanceTimersByTime(100);
    pong();
  }
}

/** Nothing arrives until then. */
function silence(untilMs: number): void {
  vi.advanceTimersByTime(Math.max(untilMs - performance.now(), 0));
}

/** Pictures and answers arrive until then. */
function plays(untilMs: number): void {
  playFor((untilMs - performance.now()) / 1000);
}

/** When, what happens until or at that time, what the page is told meanwhile, and all peers. */
type Row = [atMs: number, happens: (untilMs: number) => void, told: string, peers: string];

/** Plays rows from now on; of the peers, "o" is one that is open, "-" one that is closed. */
function trace(...rows: Row[]): void {
  const fromMs = performance.now();
  let seen = states.length;
  for (const [atMs, happens, told, all] of rows) {
    if (happens !== silence && happens !== plays) silence(fromMs + atMs);
    happens(fromMs + atMs);
    const now = states.slice(seen).map(({ is }) => is);
    const open = peers.map(({ isClosed }) => (isClosed ? "-" : "o"));
    expect([atMs, now.join(" "), open.join("")]).toEqual([atMs, told, all]);
    seen = states.length;
  }
}

it("replaces a peer that has fallen silent by another", () => {
  trace(
    // ms, what happens, what the page is told, and the peers
    [100, open, "connected", "o"],
    [6100, plays, "", "o"],
    [6700, silence, "", "o"],
    [7000, silence, "silent", "o"],
    [9300, silence, "", "o"],
    [9400, silence, "connecting", "oo"], // the old one may recover
    [9500, () => peer().events.reached(), "", "oo"],
    [9600, () => peer().events.answered(), "", "-o"], // the server has dropped it, too
    [9700, greet, "connected", "-o"],
  );
});

it("passes on what the server answers about the robot's controls", () => {
  open();
  peer().events.received("drive", JSON.stringify(["operated", 4, null]));
  expect(answers).toEqual([{ type: "operated", seq: 4, refused: null }]);
});

it("is connected after the server's hello, and passes its messages on", () => {
  expect(states.at(-1)).toEqual({ is: "connecting", reason: null });
  open();
  expect(states.at(-1)).toEqual({ is: "connected" });
  expect(heard[0]?.type).toBe("hello");
});

it("aligns the clock by its heartbeat", () => {
  open();
  pong();
  expect(link.clock.toServerMs(performance.now())).toBeCloseTo(performance.now() + 5000);
});

it("keeps the newest beat for the next command, but none of the previous peer", () => {
  open();
  pong();
  expect(link.beat).toBe("x7-_2A");
  peer().events.received("drive", JSON.stringify(["beat", "second"]));
  expect(link.beat).toBe("second");
  expect(answers).toEqual([]);
  link.connect();
  peer().events.reached();
  peer().events.answered();
  expect(link.beat).toBeNull();
});

it("pings five times a second while it may drive, once over a slow link", () => {
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
  open();
  expect(link.isThin).toBe(false);
});

/** When attempts begin in the next seconds, in ms from the loss, which is reported first. */
function beginnings(seconds: number, fails: boolean): number[] {
  const found: number[] = [];
  const startMs = performance.now();
  let count = peers.length;
  peer().events.lost(says("The connection was lost."), null);
  while (performance.now() < startMs + seconds * 1000) {
    while (peers.length > count) {
      count++;
      found.push(performance.now() - startMs);
      if (fails) peer().events.lost(says("The server cannot be reached."), null);
    }
    vi.advanceTimersByTime(10);
  }
  return found.map(Math.round);
}

describe("after the loss of a connection", () => {
  beforeEach(() => {
    open();
    playFor(6);
  });

  it("new peers are tried at once, soon, then every second for 20 s", () => {
    const found = beginnings(40, true);
    const near = found.map((ms) => Math.round(ms / 100) / 10);
    expect(near.slice(0, 9)).toEqual([0, 0.3, 0.7, 1.1, 1.5, 1.9, 2.3, 3.3, 4.3]);
    expect(near.filter((s) => s <= 20)).toHaveLength(24);
    expect(near.at(-1)).toBeGreaterThan(30);
  });

  it("an unanswered attempt is replaced every second", () => {
    const found = beginnings(8, false);
    const apart = found.slice(1).map((ms, i) => ms - (found[i] ?? 0));
    expect(found.length).toBeGreaterThanOrEqual(7);
    for (const ms of apart) expect(ms).toBeLessThanOrEqual(1250);
    expect(peers.slice(0, -1).every((old) => old.isClosed)).toBe(true);
  });

  it("an answered attempt may take four seconds to open", () => {
    trace(
      [0, () => peer().events.lost(says("The connection was lost."), null), "connecting", "-o"],
      [0, () => peer().events.reached(), "", "-o"],
      [0, () => peer().events.answered(), "", "-o"],
      [3900, silence, "", "-o"],
      [4400, silence, "connecting", "-oo"],
    );
  });

  it("says why it retries, and when, after a longer pause", () => {
    peer().events.lost(says("The server is full."), null);
    vi.advanceTimersByTime(0);
    expect(states.at(-1)).toEqual({ is: "connecting", reason: says("The server is full.") });
    peer().events.lost(says("Too many."), 5000);
    expect(states.at(-1)?.is).toBe("waiting");
  });

  it("waits as long as the server asks, whatever else happens", () => {
    trace(
      [0, () => peer().events.lost(says(""), null), "connecting", "-o"],
      [0, () => peer().events.lost(says("Too many people."), 5000), "waiting", "-o"],
      [4900, () => link.hurry(), "", "-o"],
      [4900, () => link.networkChanged(), "", "-o"],
      [5600, silence, "connecting", "-oo"],
    );
  });

  it("a slow link that answers after all continues, without a new attempt", () => {
    const slow = peer();
    answerFor(2);
    link.isThin = true;
    vi.advanceTimersByTime(4500);
    expect(peers).toHaveLength(2);
    for (let message = 0; message < 5; message++) {
      vi.advanceTimersByTime(500);
      slow.events.received("state", JSON.stringify(hello()).replace("hello", "notice"));
    }
    expect(peers).toHaveLength(2);
    const late = slow.sent.at(-1);
    slow.events.received("drive", JSON.stringify(["pong", late?.id, late?.sentMs, 9000, "x7-_2A"]));
    expect(states.at(-1)).toEqual({ is: "connected" });
    expect(peers[1]?.isClosed).toBe(true);
    vi.advanceTimersByTime(1500);
    expect(peers).toHaveLength(2);
  });

  it("a slow link gets ten seconds for each attempt", () => {
    link.isThin = true;
    peer().events.lost(says(""), null);
    vi.advanceTimersByTime(0);
    const count = peers.length;
    vi.advanceTimersByTime(9900);
    expect(peers).toHaveLength(count);
    vi.advanceTimersByTime(200);
    expect(peers).toHaveLength(count + 1);
  });
});

it("counts a connection that breaks at once as a failure, a steady one not", () => {
  expect(beginnings(0.31, false)).toHaveLength(1);
  open();
  expect(beginnings(0.35, false)).toHaveLength(0);
  vi.advanceTimersByTime(60);
  expect(peers).toHaveLength(3);
  open();
  playFor(6);
  expect(beginnings(0.01, false)).toHaveLength(1);
});

it.each([
  [0, 1000],
  [0.999, 1999],
])("waits a moment of its own after a goodbye (random %d)", (random, waitMs) => {
  open();
  playFor(6);
  vi.mocked(Math.random).mockReturnValue(random);
  const text = { code: "door.goodbye" };
  peer().events.received("state", JSON.stringify({ type: "goodbye", text }));
  expect(states.at(-1)).toMatchObject({ reason: text });
  expect(peer().isClosed).toBe(true);
  vi.advanceTimersByTime(waitMs - 1);
  expect(peers).toHaveLength(1);
  vi.advanceTimersByTime(1);
  expect(peers).toHaveLength(2);
});

describe("a peer that has fallen silent", () => {
  let old: ReturnType<typeof peer>;

  beforeEach(() => {
    link.mayDrive = true;
    open();
    answerFor(6);
    old = peer();
    const before = peers.length;
    vi.advanceTimersByTime(1900);
    expect(peers).toHaveLength(before);
    vi.advanceTimersByTime(500);
    expect(peers).toHaveLength(before + 1);
  });

  it("is kept and pinged until the server has answered another", () => {
    const before = old.sent.length;
    vi.advanceTimersByTime(3000);
    expect(old.isClosed).toBe(false);
    expect(old.sent.length - before).toBeGreaterThanOrEqual(14);
    peer().events.reached();
    expect(old.isClosed).toBe(false);
    peer().events.answered();
    expect(old.isClosed).toBe(true);
    expect(link.peer).toBe(peer());
  });

  it("shows by its first message that the network is back: a new attempt begins at once", () => {
    vi.advanceTimersByTime(400);
    const stuck = peer();
    old.events.received("drive", JSON.stringify(["pong", 99, 0, 0, "x7-_2A"]));
    expect(peer()).not.toBe(stuck);
    expect(stuck.isClosed).toBe(true);
    expect(states.at(-1)?.is).toBe("connecting");
  });

  it("does not restart an attempt that has reached the server", () => {
    vi.advanceTimersByTime(400);
    const good = peer();
    good.events.reached();
    old.events.received("drive", JSON.stringify(["pong", 99, 0, 0, "x7-_2A"]));
    expect(peer()).toBe(good);
    old.events.lost(says("The connection was lost."), null);
    expect(peer()).toBe(good);
    open();
    expect(states.at(-1)).toEqual({ is: "connected" });
  });

  it("may break meanwhile without ending the attempt", () => {
    const tried = peer();
    old.events.lost(says("The connection was lost."), null);
    expect(peer()).toBe(tried);
    expect(tried.isClosed).toBe(false);
  });
});

it("keeps room for pings while there is no network, but sends what is urgent", () => {
  const sendAll = () => {
    link.sendDrive(command);
    link.sendDrive(command, true);
    return peer()
      .sent.splice(0)
      .filter(({ type }) => type === "drive").length;
  };
  const command: DriveIn = {
    type: "drive",
    seq: 1,
    turn: 1,
    sent_server_ms: 0,
    linear: 1,
    angular: 0,
    held: true,
    speed: "slow",
    seen_server_ms: null,
    beat: null,
  };
  open();
  vi.stubGlobal("navigator", { onLine: false });
  expect(sendAll()).toBe(2); // not silent: the server may be on this machine
  silence(performance.now() + 400);
  expect(
    peer()
      .sent.splice(0)
      .some(({ type }) => type === "ping"),
  ).toBe(true);
  expect(sendAll()).toBe(1);
  vi.stubGlobal("navigator", { onLine: true });
  expect(sendAll()).toBe(2); // a stall, and not the way to the server
});

describe("when the network has changed", () => {
  it("retries at once if the connection is doubtful", () => {
    open();
    playFor(6);
    vi.advanceTimersByTime(1000);
    const before = peers.length;
    link.networkChanged();
    expect(peers).toHaveLength(before + 1);
  });

  it("restarts an attempt that has begun", () => {
    link.networkChanged();
    expect(peers).toHaveLength(2);
    expect(peers[0]?.isClosed).toBe(true);
  });

  it("pings first if all seems well, and keeps a connection that answers", () => {
    open();
    playFor(6);
    const before = peer().sent.length;
    link.networkChanged();
    expect(peer().sent.length).toBe(before + 1);
    playFor(2);
    expect(peers).toHaveLength(1);
  });

  it("retries when no answer has arrived for a little longer than answers take", () => {
    open();
    playFor(6);
    link.networkChanged();
    vi.advanceTimersByTime(100);
    expect(peers).toHaveLength(1);
    vi.advanceTimersByTime(150);
    expect(peers).toHaveLength(2);
  });

  describe("and the server follows a peer to another address", () => {
    const SILENCE_MS = 1000;
    const CHECK_MS = 350;
    const MOVE_MS = 300;

    /** Drives until nothing has arrived for a second. */
    function isDoubtful(): InstanceType<typeof FakePeer> {
      open();
      playFor(6);
      const old = peer();
      old.mayMove = true;
      vi.advanceTimersByTime(SILENCE_MS);
      link.networkChanged();
      return old;
    }

    it("prepares another, and drops it when the peer continues", () => {
      const old = isDoubtful();
      const fresh = peer();
      expect(fresh).not.toBe(old);
      expect(fresh.mayOffer).toBe(false);
      old.events.received("drive", JSON.stringify(["beat", "x7-_2A"]));
      expect(fresh.isClosed).toBe(true);
      expect(old.isClosed).toBe(false);
      expect(link.peer).toBe(old);
      expect(states.at(-1)).toEqual({ is: "connected" });
    });

    it("offers the other when the peer has not continued in time", async () => {
      const old = isDoubtful();
      await vi.advanceTimersByTimeAsync(CHECK_MS);
      expect(peers.at(-1)?.mayOffer).toBe(true);
      peer().events.reached();
      peer().events.offered();
      old.events.received("drive", JSON.stringify(["beat", "x7-_2A"]));
      link.heard();
      expect(peer().isClosed).toBe(false);
      open();
      expect(old.isClosed).toBe(true);
    });

    it("counts a picture as a sign that the peer continues", async () => {
      const old = isDoubtful();
      vi.advanceTimersByTime(100);
      link.heard();
      await vi.advanceTimersByTimeAsync(CHECK_MS);
      expect(peers.filter(({ isClosed }) => !isClosed)).toEqual([old]);
      expect(states.at(-1)).toEqual({ is: "connected" });
    });

    it("continues a peer that answers late, but before another is offered", async () => {
      const old = isDoubtful();
      await vi.advanceTimersByTimeAsync(CHECK_MS);
      link.heard();
      expect(peers.filter(({ isClosed }) => !isClosed)).toEqual([old]);
    });

    it.each([
      { isThin: false, pings: 7 },
      { isThin: true, pings: 1 },
    ])("is asked again and again, over a thin link ($isThin) once", ({ isThin, pings }) => {
      open();
      playFor(6);
      peer().mayMove = true;
      link.isThin = isThin;
      const before = peer().sent.length;
      link.networkChanged();
      vi.advanceTimersByTime(MOVE_MS);
      expect(peers[0]?.sent.length).toBe(before + pings);
    });

    it("pings once, however often the change is reported", () => {
      isDoubtful();
      const before = peers.length;
      link.networkChanged();
      expect(peers).toHaveLength(before);
    });

    it("does not hold earlier unanswered pings against the peer", () => {
      link.mayDrive = true;
      open();
      answerFor(6);
      const old = peer();
      old.mayMove = true;
      vi.advanceTimersByTime(2500);
      link.networkChanged();
      const before = peers.length;
      old.events.received("drive", JSON.stringify(["beat", "x7-_2A"]));
      vi.advanceTimersByTime(400);
      expect(peers).toHaveLength(before);
      expect(link.peer).toBe(old);
    });

    it("waits at most a second for a peer that was slow before", () => {
      open();
      playFor(6);
      peer().mayMove = true;
      vi.spyOn(link.clock, "slowestMs", "get").mockReturnValue(4000);
      link.networkChanged();
      vi.advanceTimersByTime(1400);
      expect(peers).toHaveLength(2);
    });

    it("retries if all seemed well but nothing has arrived", () => {
      open();
      playFor(6);
      peer().mayMove = true;
      link.networkChanged();
      vi.advanceTimersByTime(200);
      expect(peers).toHaveLength(1);
      vi.advanceTimersByTime(150);
      expect(peers).toHaveLength(2);
    });
  });
});

it("gives an unmovable peer the time that its answers take", () => {
  open();
  playFor(6);
  vi.spyOn(link.clock, "slowestMs", "get").mockReturnValue(2000);
  link.networkChanged();
  vi.advanceTimersByTime(2100);
  expect(peers).toHaveLength(1);
  vi.advanceTimersByTime(100);
  expect(peers).toHaveLength(2);
});

it("gives up a first attempt without success after ten seconds", () => {
  trace([9999, silence, "", "o"], [10_001, silence, "connecting", "-o"]);
});

it("hurries only while it waits", () => {
  link.hurry();
  expect(peers).toHaveLength(1);
  beginnings(40, true);
  const before = peers.length;
  expect(states.at(-1)?.is).toBe("waiting");
  link.hurry();
  expect(peers).toHaveLength(before + 1);
});

describe("a page that may not stay", () => {
  const ended = { type: "ended", text: says("The robot is closed."), openings: [] } satisfies Ended;

  it("shows that, and does not reconnect by itself", () => {
    open();
    peer().events.received("state", JSON.stringify(ended));
    expect(heard.at(-1)).toEqual(ended);
    expect(peer().isClosed).toBe(true);
    trace(
      [60_000, silence, "", "-"],
      [60_000, () => link.networkChanged(), "", "-"],
      [60_000, () => link.hurry(), "", "-"],
    );
    expect(states.at(-1)).toEqual({ is: "closed" });
  });

  it("learns it from the answer to its offer, too", () => {
    peer().events.refused(ended);
    vi.advanceTimersByTime(60_000);
    expect(heard.at(-1)).toEqual(ended);
    expect(peers).toHaveLength(1);
  });
});

it("stays closed until it is told to connect", () => {
  trace(
    [0, open, "connected", "o"],
    [0, () => link.close(), "closed", "-"],
    [60_000, silence, "", "-"],
    [60_000, () => link.connect(), "connecting", "-o"],
  );
});

/** Nothing arrives for this long. */
function fallSilentFor(seconds: number): void {
  vi.advanceTimersByTime(seconds * 1000);
}

/** Thirty pictures a second arrive, and an answer to every ping with the next of them. */
function playFor(seconds: number): void {
  let answered = peer().sent.length;
  for (let frame = 0; frame < seconds * 30; frame++) {
    vi.advanceTimersByTime(1000 / 30);
    link.heard();
    if (peer().sent.length > answered) pong();
    answered = peer().sent.length;
  }
}

it.each([true, false])("reports within a second that no answer comes, driving: %s", (mayDrive) => {
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

it("counts a picture, or a message of any kind, as an answer", () => {
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

it("sends extra pings only if nothing arrives", () => {
  open();
  playFor(2);
  const before = peer().sent.length;
  playFor(5);
  expect(peer().sent.length - before).toBe(5);
  fallSilentFor(0.65);
  expect(peer().sent.length - before).toBe(7);
});

it("waits for an answer for as long as answers take on this link", () => {
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
        const text = JSON.stringify(["pong", ping.id, ping.sentMs, ping.sentMs + 5000, "x7-_2A"]);
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

it("allows a slow link to stall for a second", () => {
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

it("reports no silence before the server's hello", () => {
  peer().events.opened();
  fallSilentFor(2);
  expect(states).toEqual([{ is: "connecting", reason: null }]);
});

it("closes and stops retrying if the server is full but names LiveKit rooms", () => {
  peer().events.sent(sentToRoom());
  expect(sentTo).toEqual([sentToRoom()]);
  expect(states.at(-1)).toEqual({ is: "closed" });
  trace([60_000, silence, "", "-"], [60_000, () => link.connect(), "connecting", "-o"]);
});

it("says how far a given-up attempt came", () => {
  peer().events.reached();
  peer().events.answered();
  peer().trouble = says("Nothing gets through.");
  vi.advanceTimersByTime(10_000);
  expect(peers).toHaveLength(2);
  expect(states.at(-1)).toEqual({ is: "connecting", reason: says("Nothing gets through.") });
});
