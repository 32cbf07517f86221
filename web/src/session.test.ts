// @vitest-environment happy-dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { PeerEvents } from "./link/peer";
import { type DriveIn, MAX_NAME_CHARS, type StateIn, type StateOut } from "./messages";
import { type Session, startSession } from "./session";
import { hello, room } from "./testing/messages";

const { FakePeer, peers } = vi.hoisted(() => {
  const made: InstanceType<typeof Fake>[] = [];

  /** Stands where the browser's peer connection would, and answers every ping at once. */
  class Fake {
    sound = { track: null };
    picture = { track: null };
    sent: (DriveIn | StateIn)[] = [];

    constructor(readonly events: PeerEvents) {
      made.push(this);
    }

    async connect(): Promise<void> {}

    send(_channel: string, text: string): void {
      const message = JSON.parse(text);
      this.sent.push(message);
      if (message.type !== "ping") return;
      const { id, sent_page_ms } = message;
      const pong = { type: "pong", id, sent_page_ms, server_ms: sent_page_ms };
      this.events.received("drive", JSON.stringify(pong));
    }

    close(): void {}
  }

  return { FakePeer: Fake, peers: made };
});

vi.mock("./link/peer", () => ({ Peer: FakePeer }));

let session: Session;

beforeEach(() => {
  vi.useFakeTimers();
  peers.length = 0;
  session = startSession();
});

afterEach(() => {
  vi.clearAllTimers();
  vi.useRealTimers();
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
  return peer().sent.flatMap((message) => (message.type === "drive" ? [message.turn] : []));
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

it("says so when it is to acknowledge and this browser cannot", async () => {
  receive(hello({ acknowledge: true }));
  await vi.advanceTimersByTimeAsync(0);
  expect(session.state.notice.value?.text).toContain("cannot say what it has received");
  expect(peers).toHaveLength(1);
});
