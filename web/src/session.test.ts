// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { PeerEvents } from "./link/peer";
import { MAX_NAME_CHARS, type StateIn, type StateOut } from "./messages";
import { type Session, startSession } from "./session";
import { hello, room, served } from "./testing/messages";

const { FakePeer, peers } = vi.hoisted(() => {
  const made: InstanceType<typeof Fake>[] = [];

  const receiver = () => ({
    track: null,
    getStats: async () => new Map(),
    getSynchronizationSources: () => [],
  });

  /** Stands where the browser's peer connection would, and answers every ping at once. */
  class Fake {
    sound = receiver();
    picture = receiver();
    sent: StateIn[] = [];
    rows: unknown[][] = [];

    constructor(readonly events: PeerEvents) {
      made.push(this);
    }

    async connect(): Promise<void> {}

    send(channel: string, text: string): void {
      const message = JSON.parse(text);
      if (channel === "state") {
        this.sent.push(message);
        return;
      }
      this.rows.push(message);
      const [type, id, sentMs] = message;
      if (type !== "ping") return;
      this.events.received("drive", JSON.stringify(["pong", id, sentMs, sentMs]));
    }

    close(): void {}
  }

  return { FakePeer: Fake, peers: made };
});

vi.mock("./link/peer", () => ({ Peer: FakePeer }));

/** Each test is alone: the session of the one before does not ask who else is there. */
class Alone {
  onmessage = null;
  postMessage(): void {}
}

let session: Session;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("BroadcastChannel", Alone);
  peers.length = 0;
  session = startSession();
});

afterEach(() => {
  vi.clearAllTimers();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

function peer() {
  const newest = peers.at(-1);
  if (!newest) throw new Error("there is no peer");
  return newest;
}

function receive(...messages: StateOut[]): void {
  for (const message of messages) peer().events.received("state", JSON.stringify(message));
}

/** The turns of the set-points that went out over the newest peer. */
function turns(): number[] {
  return peer().rows.flatMap(([type, , turn]) => (type === "drive" ? [turn as number] : []));
}

it("drives after a reconnect only when the new room says so", () => {
  peer().events.opened();
  receive(hello({ viewer: 1 }), room({ operator: 1, number: 7 }));
  vi.advanceTimersByTime(100);
  expect(turns()).toContain(7);

  peer().events.lost("The connection was lost.");
  vi.advanceTimersByTime(0);
  expect(peers).toHaveLength(2);
  peer().events.opened();
  receive(hello({ viewer: 1 }));
  vi.advanceTimersByTime(100);
  expect(session.state.isConnected.value).toBe(true);
  expect(turns()).toEqual([]);

  receive(room({ operator: 1, number: 8 }));
  expect(turns()).toEqual([8]);
});

it("cuts a name where the server does", () => {
  peer().events.opened();
  session.actions.setName(` ${"x".repeat(100)} `);
  const name = "x".repeat(MAX_NAME_CHARS);
  expect(peer().sent).toContainEqual({ type: "name", name });
  expect(session.state.preferences.value.name).toBe(name);
});

it("keeps what the room said of oneself while the connection is lost", () => {
  peer().events.opened();
  receive(hello({ viewer: 1 }), room({ operator: 1 }));
  peer().events.lost("The connection was lost.");
  vi.advanceTimersByTime(0);
  expect(session.state.link.value.is).toBe("connecting");
  expect(session.state.me.value?.role).toBe("operator");
});

it("sends the policy that was chosen, and changes it without a new connection", () => {
  peer().events.opened();
  receive(hello());
  const want = { type: "want", sound: false, picture: true, size: "640x480" };
  expect(peer().sent.at(-1)).toEqual({ ...want, policy: null });
  session.actions.setPolicy("video-first");
  expect(peer().sent.at(-1)).toEqual({ ...want, policy: "video-first" });
  expect(session.state.preferences.value.policy).toBe("video-first");
  session.actions.setPolicy(null);
  expect(peer().sent.at(-1)).toEqual({ ...want, policy: null });
  expect(peers).toHaveLength(1);
});

it("keeps what is served, for as long as the connection lasts that it was said of", () => {
  peer().events.opened();
  receive(hello(), served({ link_bps: 2_000_000 }));
  expect(session.state.served.value).toEqual(served({ link_bps: 2_000_000 }));
  peer().events.lost("The connection was lost.");
  vi.advanceTimersByTime(0);
  expect(session.state.served.value).toBeNull();
});

it("speaks less where the server says that the way is thin", async () => {
  const rowsIn = async (ms: number) => {
    const before = peer().rows.length;
    await vi.advanceTimersByTimeAsync(ms);
    return peer().rows.length - before;
  };
  peer().events.opened();
  receive(hello({ viewer: 1 }), room({ waiting: [1], operator: 2 }));
  await vi.advanceTimersByTimeAsync(2000);
  expect(await rowsIn(5000)).toBe(45);
  receive(served({ link_bps: 50_000 }));
  await vi.advanceTimersByTimeAsync(1000);
  expect(await rowsIn(5000)).toBe(10);
});

it("says so when it is to acknowledge and this browser cannot", async () => {
  receive(hello({ acknowledge: true }));
  await vi.advanceTimersByTimeAsync(0);
  expect(session.state.notice.value?.text).toContain("cannot say what it has received");
  expect(peers).toHaveLength(1);
});
