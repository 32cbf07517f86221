import { describe, expect, it } from "vitest";
import { hello, pressedBy, room } from "../testing/messages";
import { says } from "../words/said";
import { face, type Seen } from "./face";

/** A guest who watches an idle robot. */
function seen(change: Partial<Seen> = {}, people: Parameters<typeof room>[0] = {}): Seen {
  const now = room({ watching: [1], ...people });
  return {
    link: { is: "connected" },
    isConnected: true,
    hello: hello({ viewer: 1 }),
    room: now,
    me: now.viewers.find((one) => one.id === 1) ?? null,
    isDriving: now.turn.operator === 1,
    secondsLeft: null,
    mayRelease: false,
    missedCall: null,
    isJustOver: false,
    ...change,
  };
}

const stop = pressedBy("Cleo");

describe("a face for each state", () => {
  it("connecting: what happens, and nothing to press", () => {
    const first = face(
      seen({ link: { is: "connecting", reason: null }, isConnected: false, hello: null, me: null }),
    );
    expect(first).toMatchObject({ tone: "connecting", headline: "Connecting…", queue: null });
  });

  it("after an attempt that failed: no promise of a picture", () => {
    const link = { is: "connecting", reason: says("No UDP.") } as const;
    const again = face(seen({ link, isConnected: false, hello: null, me: null }));
    expect(again).toMatchObject({ tone: "trouble", next: "" });
  });

  it("connection lost: how long the place is kept", () => {
    const lost = {
      link: { is: "waiting", retryAtMs: 0, reason: says("") },
      isConnected: false,
    } as const;
    const words = face(seen(lost, { operator: 1, watching: [] }));
    expect(words).toMatchObject({ tone: "trouble", headline: "Connection lost" });
    expect(words.next).toContain("to keep your turn");
  });

  it("watching: one press joins the queue", () => {
    expect(face(seen())).toMatchObject({ headline: "Nobody is driving", queue: "join" });
  });

  it("watching uninvited: why there is nothing to press", () => {
    const words = face(seen({ hello: hello({ viewer: 1, may_queue: false }) }));
    expect(words.queue).toBeNull();
    expect(words.note).toContain("Ask the host for a link");
  });

  it("waiting: the place and what is ahead", () => {
    const words = face(seen({}, { operator: 2, waiting: [1], watching: [] }));
    expect(words.headline).toBe("You are next");
    expect(words.wait).toBe("about 30 s");
    expect(words.queue).toBe("leave");
  });

  it("driving, and its last seconds", () => {
    const mine = { operator: 1, watching: [] };
    expect(face(seen({ secondsLeft: 40 }, mine)).tone).toBe("driving");
    expect(face(seen({ secondsLeft: 10 }, mine)).tone).toBe("ending");
  });

  it("stopped: by whom, for every role, and who can release it", () => {
    const others = face(seen({}, { operator: 2, watching: [1], stop }));
    expect(others).toMatchObject({ tone: "stopped", headline: "Stopped by Cleo", releases: false });
    const mine = face(seen({ mayRelease: true }, { operator: 1, watching: [], stop }));
    expect(mine).toMatchObject({ tone: "stopped", releases: true, queue: "end", wait: null });
  });

  it("a robot that does not answer: trouble for everybody", () => {
    const words = seen();
    if (words.room)
      words.room = { ...words.room, robot: { ...words.room.robot, connected: false } };
    expect(face(words).tone).toBe("trouble");
  });

  it("turn over: thanks, and how long until the next", () => {
    const words = face(seen({ isJustOver: true }, { operator: 2, waiting: [1], watching: [] }));
    expect(words.headline).toContain("Thanks for driving");
    expect(words.next).toContain("You are next");
  });
});
