// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Session } from "./actions";
import type { PeerEvents } from "./link/peer";
import { type Ended, MAX_NAME_CHARS, type StateIn, type StateOut } from "./messages";
import { startSession } from "./session";
import { eventually } from "./testing/eventually";
import { aboard, hello, pressedBy, room, sentToRoom, served } from "./testing/messages";
import { LateWords } from "./words/lateWords";
import { said, says } from "./words/said";

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
    cameras = [];
    sent: StateIn[] = [];
    rows: unknown[][] = [];

    constructor(readonly events: PeerEvents) {
      made.push(this);
    }

    async connect(): Promise<void> {}

    waitingBytes = 0;

    send(channel: string, text: string): boolean {
      const message = JSON.parse(text);
      if (channel === "state") {
        this.sent.push(message);
        return true;
      }
      this.rows.push(message);
      const [type, id, sentMs] = message;
      if (type === "ping") {
        this.events.received("drive", JSON.stringify(["pong", id, sentMs, sentMs]));
      }
      return true;
    }

    async speak(): Promise<void> {}

    shape(): void {}

    close(): void {}
  }

  return { FakePeer: Fake, peers: made };
});

vi.mock("./link/peer", () => ({ Peer: FakePeer }));

/** What watches at others, once it is loaded. */
const away = vi.hoisted(() => ({
  isOnScreen: false,
  picture: undefined,
  sent: vi.fn(),
  linkChanged: vi.fn(),
  arrives: vi.fn(),
  presented: vi.fn(),
  leave: vi.fn(),
  giveUp: vi.fn(),
  ask: vi.fn(() => true),
  toServerMs: () => 4000,
  made: 0,
}));

vi.mock("./rooms/roomViewer", () => ({
  RoomViewer: function make() {
    away.made++;
    return away;
  },
}));

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
});

function peer() {
  const newest = peers.at(-1);
  if (!newest) throw new Error("there is no peer");
  return newest;
}

/** The server answers, and both channels open. */
function open(): void {
  peer().events.answered();
  peer().events.opened();
}

function receive(...messages: StateOut[]): void {
  for (const message of messages) peer().events.received("state", JSON.stringify(message));
}

/** The turns of the set-points that went out over the newest peer. */
function turns(): number[] {
  return peer().rows.flatMap(([type, , turn]) => (type === "drive" ? [turn as number] : []));
}

it.each([
  ["at once where its words are there", 1000, true],
  ["without them after twelve seconds", 11_900, false],
])("that came over a thin link connects %s", async (_when, waitsMs, areThere) => {
  open();
  receive(hello({ viewer: 1 }));
  const loaded = [{ transferSize: 60_000, responseStart: 0, responseEnd: 6000 }];
  vi.spyOn(performance, "getEntriesByType").mockReturnValue(loaded as never);
  let there = () => {};
  const words = new Promise<void>((resolve) => {
    there = resolve;
  });
  vi.spyOn(LateWords.prototype, "ask").mockReturnValue(words);
  const before = peers.length;
  startSession();
  await vi.advanceTimersByTimeAsync(waitsMs);
  expect(peers).toHaveLength(before);
  if (areThere) there();
  await vi.advanceTimersByTimeAsync(areThere ? 0 : 200);
  expect(peers).toHaveLength(before + 1);
});

it("drives after a reconnect only when the new room says so", () => {
  open();
  receive(hello({ viewer: 1 }), room({ operator: 1, number: 7 }));
  vi.advanceTimersByTime(100);
  expect(turns()).toContain(7);

  peer().events.lost(says("The connection was lost."), null);
  vi.advanceTimersByTime(400);
  expect(peers).toHaveLength(2);
  open();
  receive(hello({ viewer: 1 }));
  vi.advanceTimersByTime(100);
  expect(session.state.isConnected.value).toBe(true);
  expect(turns()).toEqual([]);

  receive(room({ operator: 1, number: 8 }));
  expect(turns()).toEqual([8]);
});

describe("input", () => {
  beforeEach(() => {
    open();
    receive(hello({ viewer: 1 }), room({ operator: 1, number: 7 }));
    vi.advanceTimersByTime(1000);
  });

  /** What was sent in the same task: whether anything is held, and how far ahead. */
  function said(during: () => void): unknown[] {
    const before = peer().rows.length;
    during();
    const drives = peer()
      .rows.slice(before)
      .filter(([type]) => type === "drive");
    return drives.map(([, , , , linear, , held]) => [held, linear]);
  }

  it("say in each command whether they hold anything", () => {
    expect(said(() => session.actions.press("a", "forward"))).toEqual([[true, 1]]);
    expect(said(() => session.actions.press("b", "back"))).toEqual([[true, 0]]);
    session.actions.release("b");
    expect(said(() => session.actions.release("a"))).toEqual([[false, 0]]);
  });

  it("say three times within 100 ms that they have let go", () => {
    session.actions.press("a", "forward");
    session.actions.release("a");
    // Without the repeats there would be one in this time, after 50 ms.
    expect(said(() => vi.advanceTimersByTime(95)).length).toBeGreaterThanOrEqual(2);
  });

  it("say it three times before the task ends in which the page loses them", () => {
    session.actions.press("a", "forward");
    const words = said(() => window.dispatchEvent(new Event("pagehide")));
    expect(words.length).toBeGreaterThanOrEqual(3);
    expect(new Set(words.map(String))).toEqual(new Set(["false,0"]));
  });

  it("say the chosen speed at once", () => {
    for (const speed of ["fast", "slow"] as const) {
      session.actions.setSpeed(speed);
      expect(peer().rows.at(-1)?.[7]).toBe(speed);
    }
  });

  it("end with a turn, whose seconds the page counts down", () => {
    receive(room({ operator: 1, number: 7, endsMs: performance.now() + 30_000 }));
    vi.advanceTimersByTime(1000);
    const leftS = session.state.secondsLeft.value ?? 0;
    vi.advanceTimersByTime(1000);
    expect(session.state.secondsLeft.value).toBe(leftS - 1);
    expect(leftS).toBe(29);
  });

  it("are empty from the moment of a stop until the first press after its release", () => {
    const stop = pressedBy("Bob", { number: 3 });
    session.actions.press("a", "forward");
    expect(said(() => receive(room({ operator: 1, number: 7, stop })))).toEqual([[false, 0]]);
    session.actions.press("a", "forward");
    receive(room({ operator: 1, number: 7 }));
    expect(session.state.isFreshlyReleased.value).toBe(true);
    vi.advanceTimersByTime(500);
    expect(session.state.held.value.size).toBe(0);
    expect(said(() => session.actions.press("a", "forward"))).toEqual([[true, 1]]);
    expect(session.state.isFreshlyReleased.value).toBe(false);
  });

  it("stop the robot by the channel before anything else is said", () => {
    const fetching = vi.fn(() => Promise.reject(new TypeError("Failed to fetch")));
    vi.stubGlobal("fetch", fetching);
    session.actions.press("a", "forward");
    session.actions.stop();
    expect(peer().sent.at(-1)).toEqual({ type: "stop", press: expect.any(Number) });
    expect(fetching).toHaveBeenCalledOnce();
    expect(session.state.held.value.size).toBe(0);
  });

  it("say nothing of a picture that is switched off", () => {
    receive({
      type: "rtp_clock",
      kind: "video",
      rtp_origin: 0,
      rate_hz: 90_000,
      origin_server_ms: performance.now() - 40,
    });
    let present: VideoFrameRequestCallback = () => {};
    const video = document.createElement("video");
    session.attachPicture(
      Object.assign(video, {
        requestVideoFrameCallback: (next: VideoFrameRequestCallback) => {
          present = next;
          return 1;
        },
        cancelVideoFrameCallback: () => {},
      }),
    );
    present(performance.now(), {
      presentationTime: performance.now(),
      rtpTimestamp: 0,
    } as VideoFrameCallbackMetadata);
    const seen = () => {
      session.actions.press("a", "left");
      session.actions.release("a");
      return peer().rows.findLast(([type]) => type === "drive")?.[8];
    };
    expect(seen()).not.toBeNull();
    session.actions.setPicture(false);
    expect(seen()).toBeNull();
    session.actions.setPicture(true);
    expect(seen()).toBeNull();
  });
});

it("cuts a name where the server does", () => {
  open();
  session.actions.setName(` ${"x".repeat(100)} `);
  const name = "x".repeat(MAX_NAME_CHARS);
  expect(peer().sent).toContainEqual({ type: "name", name });
  expect(session.state.preferences.value.name).toBe(name);
});

it("carries a press over a page that moves under it", () => {
  document.body.innerHTML = "<p><button>Join</button></p>";
  const clicked = vi.fn();
  document.querySelector("button")?.addEventListener("click", clicked);
  document.elementFromPoint = () => null;
  const press = new PointerEvent("pointerdown", { bubbles: true });
  document.querySelector("button")?.dispatchEvent(press);
  const click = new MouseEvent("click", { bubbles: true, detail: 1 });
  document.querySelector("p")?.dispatchEvent(click);
  expect(clicked).toHaveBeenCalledOnce();
});

it("keeps what the room said of oneself while the connection is lost", () => {
  open();
  receive(hello({ viewer: 1 }), room({ operator: 1 }));
  peer().events.lost(says("The connection was lost."), null);
  vi.advanceTimersByTime(0);
  expect(session.state.link.value.is).toBe("connecting");
  expect(session.state.me.value?.role).toBe("operator");
});

it("sends the policy that was chosen, and changes it without a new connection", () => {
  open();
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
  open();
  receive(hello(), served({ link_bps: 2_000_000 }));
  expect(session.state.served.value).toEqual(served({ link_bps: 2_000_000 }));
  peer().events.lost(says("The connection was lost."), null);
  vi.advanceTimersByTime(400);
  peer().events.answered();
  expect(session.state.served.value).toBeNull();
});

it("speaks less where the server says that the link is slow", async () => {
  const rowsIn = async (ms: number) => {
    const before = peer().rows.length;
    await vi.advanceTimersByTimeAsync(ms);
    return peer().rows.length - before;
  };
  open();
  receive(hello({ viewer: 1 }), room({ waiting: [1], operator: 2 }));
  await vi.advanceTimersByTimeAsync(2000);
  expect(await rowsIn(5000)).toBe(45);
  receive(served({ link_bps: 50_000 }));
  await vi.advanceTimersByTimeAsync(1000);
  expect(await rowsIn(5000)).toBe(10);
});

it("asks for the server's words once picture and sound are there, or are late", () => {
  const ask = vi.spyOn(LateWords.prototype, "ask");
  const { state, actions } = session;
  actions.setSound(true);
  open();
  receive(hello({ viewer: 1 }));
  const facts = { ...state.facts.value, pictureMs: 40 };
  state.facts.value = facts;
  expect(ask).not.toHaveBeenCalled();
  state.facts.value = { ...facts, soundMs: 80 };
  expect(ask).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(3900);
  expect(ask).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(200);
  expect(ask).toHaveBeenCalledTimes(2);
});

it("asks for the server's words at once where the connection is lost, not while the server is only silent", () => {
  const ask = vi.spyOn(LateWords.prototype, "ask");
  session.state.link.value = { is: "silent", sinceMs: 0 };
  expect(ask).not.toHaveBeenCalled();
  session.state.link.value = { is: "closed" };
  expect(ask).toHaveBeenCalledOnce();
});

it("says so when it is to acknowledge and this browser cannot", async () => {
  receive(hello({ acknowledge: true }));
  await vi.advanceTimersByTimeAsync(0);
  expect(said(session.state.notice.value?.text)).toContain("cannot say what it has received");
  expect(peers).toHaveLength(1);
});

describe("a page that may not stay", () => {
  const ended = { type: "ended", text: says("The robot is closed."), openings: [] } satisfies Ended;

  it("shows why, stays away, and comes back when it is asked to", () => {
    open();
    receive(hello({ viewer: 1 }), room({ watching: [1] }), ended);
    expect(session.state.ended.value).toEqual(ended);
    expect(session.state.room.value).toBeNull();
    vi.advanceTimersByTime(600_000);
    expect(peers).toHaveLength(1);
    session.actions.comeBack();
    expect(peers).toHaveLength(2);
    expect(session.state.ended.value).toBeNull();
  });

  it("comes back by itself when the robot opens, not with everybody at once", () => {
    vi.spyOn(Math, "random").mockReturnValue(0.5);
    open();
    const opens_wall_ms = Date.now() + 3_600_000;
    receive({ ...ended, openings: [{ opens_wall_ms, closes_wall_ms: opens_wall_ms + 1 }] });
    vi.advanceTimersByTime(3_609_000);
    expect(peers).toHaveLength(1);
    vi.advanceTimersByTime(2000);
    expect(peers).toHaveLength(2);
  });
});

describe("a link with a secret", () => {
  afterEach(() => {
    window.location.hash = "";
  });

  /** A server that answers like this; each request is kept. */
  function server(status: number, body: object) {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (path: string) => {
      asked.push(path);
      return new Response(JSON.stringify(body), { status });
    });
    return asked;
  }

  it("is shown to the server before the page connects, and gone from the address by then", async () => {
    const asked = server(200, { ok: true });
    window.location.hash = "#host=s3cret";
    peers.length = 0;
    session = startSession();
    expect(window.location.hash).toBe("");
    expect(peers).toHaveLength(0);
    await vi.advanceTimersByTimeAsync(0);
    expect(asked).toEqual(["api/host"]);
    expect(peers).toHaveLength(1);
    expect(session.state.entryProblem.value).toBeNull();
  });

  it("that is no good is told of for as long as it takes, and the page connects as a guest's", async () => {
    server(403, { error: "This host link has expired." });
    window.location.hash = "#host=old";
    peers.length = 0;
    session = startSession();
    await vi.advanceTimersByTimeAsync(10_000);
    expect(said(session.state.entryProblem.value)).toBe("This host link has expired.");
    expect(peers.length).toBeGreaterThan(0);
  });
});

it("begins where the browser allows no cookie, and so no word between its tabs", async () => {
  class Forbidden {
    constructor() {
      throw new DOMException("The operation is insecure.", "SecurityError");
    }
  }
  vi.stubGlobal("BroadcastChannel", Forbidden);
  session = startSession();
  await vi.advanceTimersByTimeAsync(0);
  open();
  receive(hello({ viewer: 1 }), room({ watching: [1] }));
  expect(session.state.me.value?.id).toBe(1);
});

describe("in a frame on another site", () => {
  const { dataset } = document.documentElement;

  beforeEach(() => {
    dataset.view = "embed";
    window.sessionStorage.clear();
    window.localStorage.clear();
    peers.length = 0;
  });

  afterEach(() => {
    delete dataset.view;
    window.history.replaceState(null, "", "/");
  });

  it("no key drives, stops or speaks, and no secret in the address is shown to the server", async () => {
    const fetching = vi.fn();
    vi.stubGlobal("fetch", fetching);
    // The session that every test here begins with is in no frame, and would take it.
    window.addEventListener("hashchange", (event) => event.stopImmediatePropagation(), true);
    const listening = vi.spyOn(window, "addEventListener");
    window.history.replaceState(null, "", "#host=s3cret");
    session = startSession();
    await vi.advanceTimersByTimeAsync(0);
    open();
    receive(hello({ viewer: 1 }), room({ operator: 1, number: 7 }));
    const heard = listening.mock.calls.map(([type]) => type);
    expect(heard.filter((type) => /key|pointer|gamepad|hash/.test(type))).toEqual([]);
    expect(peer().sent.filter(({ type }) => type !== "want")).toEqual([]);
    expect(fetching).not.toHaveBeenCalled();
  });

  it("keeps nothing in the browser, and takes nothing from it", async () => {
    window.localStorage.setItem("wax-preferences", '{"picture": false, "name": "Ada"}');
    session = startSession();
    expect(session.state.preferences.value).toMatchObject({ picture: true, name: "" });
    session.actions.setSound(true);
    expect(window.localStorage.getItem("wax-preferences")).toContain("Ada");
    expect(window.sessionStorage).toHaveLength(0);
  });
});

describe("a notification at one's turn", () => {
  const asks = (answer: NotificationPermission) => {
    vi.stubGlobal("Notification", { permission: answer, requestPermission: async () => answer });
    const serviceWorker = { register: async () => {}, ready: Promise.resolve() };
    vi.stubGlobal("navigator", { serviceWorker, languages: ["en"] });
  };
  const wants = async (on: boolean) => {
    session.actions.tellMe(on);
    await vi.advanceTimersByTimeAsync(0);
    return session.state.preferences.value.tells;
  };

  it("is kept where the browser allows it, until it is switched off", async () => {
    asks("granted");
    expect(await wants(true)).toBe(true);
    expect(session.state.notice.value).toBeNull();
    expect(await wants(false)).toBe(false);
  });

  it("is not where the browser does not, and says so", async () => {
    asks("denied");
    expect(await wants(true)).toBe(false);
    expect(said(session.state.notice.value?.text)).toContain("shows no notifications");
  });
});

it("rings once for each call of its own", () => {
  const made = vi.fn(function refuse() {
    throw new Error("no sound here");
  });
  vi.stubGlobal("AudioContext", made);
  open();
  const now = room({ operator: 2, waiting: [1] });
  const call = { viewer: 1, until_server_ms: 10_000 };
  receive(hello({ viewer: 1 }), now, { ...now, call }, { ...now, call });
  expect(made).toHaveBeenCalledOnce();
  receive(now, { ...now, call: { ...call, viewer: 3 } });
  expect(made).toHaveBeenCalledOnce();
  receive({ ...now, type: "room_change", viewers: [], gone: [], call });
  expect(made).toHaveBeenCalledTimes(2);
  expect(session.state.room.value?.call).toEqual(call);
  session.actions.answerCall();
  expect(peer().sent.at(-1)).toEqual({ type: "here" });
});

describe("a request of the person aboard", () => {
  const now = { ...room({ operator: 1 }), aboard: aboard() };
  const asks = (number: number) => ({ ...now, aboard: aboard({ asked: "wait", asks: number }) });

  it("rings for whoever drives, and is shown for a while", async () => {
    const made = vi.fn(function refuse() {
      throw new Error("no sound here");
    });
    vi.stubGlobal("AudioContext", made);
    open();
    receive(hello({ viewer: 1 }), now, asks(1), asks(1));
    expect(made).toHaveBeenCalledOnce();
    expect(session.state.request.value).toEqual({ asked: "wait" });
    await vi.advanceTimersByTimeAsync(8000);
    receive(asks(2));
    await vi.advanceTimersByTimeAsync(8000);
    expect(session.state.request.value).toEqual({ asked: "wait" });
    await vi.advanceTimersByTimeAsync(8000);
    expect(session.state.request.value).toBeNull();
  });

  it("is over when the person takes the robot themselves", () => {
    open();
    receive(hello({ viewer: 2 }), now, asks(1));
    expect(session.state.request.value).toEqual({ asked: "wait" });
    receive({ ...now, aboard: aboard({ mode: "hand", asked: "wait", asks: 1 }) });
    expect(session.state.request.value).toBeNull();
    receive({ ...now, aboard: aboard({ mode: "hand", asked: "left", asks: 2 }) });
    expect(session.state.request.value).toEqual({ asked: "left" });
  });

  it("is shown to who watches without a sound", () => {
    const made = vi.fn();
    vi.stubGlobal("AudioContext", made);
    open();
    receive(hello({ viewer: 2 }), now, asks(1));
    expect(made).not.toHaveBeenCalled();
    expect(session.state.request.value).toEqual({ asked: "wait" });
  });
});

describe("a page for which the server has no place", () => {
  beforeEach(async () => {
    vi.clearAllMocks();
    Object.assign(away, { isOnScreen: false, made: 0 });
    expect(session.state.link.value.is).toBe("connecting");
    peer().events.sent(sentToRoom());
    await vi.dynamicImportSettled();
  });

  it("loads what watches at others, and tells it where, each time", async () => {
    expect(away.sent).toHaveBeenCalledWith(sentToRoom());
    session.actions.comeBack();
    peer().events.sent(sentToRoom({ rooms: [] }));
    await vi.dynamicImportSettled();
    expect(away.sent).toHaveBeenCalledTimes(2);
    expect(away.made).toBe(1);
  });

  it("asks for the queue there, and by its channel once it is the server's viewer", () => {
    session.actions.join();
    session.actions.answerCall();
    expect(away.ask.mock.calls).toEqual([["join"], ["here"]]);
    away.ask.mockReturnValue(false);
    session.actions.comeBack();
    open();
    receive(hello({ viewer: 1 }));
    session.actions.leave();
    expect(peer().sent.at(-1)).toEqual({ type: "leave" });
    away.ask.mockReturnValue(true);
  });

  it("presses Stop by HTTP", () => {
    const fetching = vi.fn(async (_path: string, _init: RequestInit) => new Response("{}"));
    vi.stubGlobal("fetch", fetching);
    session.actions.stop();
    expect(fetching.mock.lastCall?.[0]).toBe("api/stop");
  });

  it("counts down by what it is told of the server's clock", () => {
    session.state.isInRoom.value = true;
    vi.advanceTimersByTime(200);
    expect(session.state.serverMs.value).toBe(4000);
  });

  it("gives the seat there back when the page is closed", () => {
    window.dispatchEvent(new Event("pagehide"));
    expect(away.giveUp).toHaveBeenCalled();
  });

  it("leaves it to that when a peer's picture comes on the screen", () => {
    away.isOnScreen = true;
    session.actions.comeBack();
    peer().events.answered();
    expect(away.arrives).toHaveBeenCalledOnce();
  });

  it("leaves the rooms where it may not stay", () => {
    session.actions.comeBack();
    open();
    receive({ type: "ended", text: says("You were removed."), openings: [] });
    expect(away.leave).toHaveBeenCalledOnce();
  });
});

it("connects again, once, with room for the cameras that the server has now", async () => {
  const greeting = hello({ viewer: 1, cameras: [{ name: "Door", axes: [] }] });
  open();
  receive(greeting);
  await vi.advanceTimersByTimeAsync(0);
  expect(peers).toHaveLength(2);
  open();
  receive(greeting);
  await vi.advanceTimersByTimeAsync(0);
  expect(peers).toHaveLength(2);
  expect(session.state.isConnected.value).toBe(true);
  expect(peer().sent).toContainEqual({ type: "look", large: null, small: true });
});

it("speaks the language that is chosen, and keeps the choice", async () => {
  session.actions.setLanguage("de");
  await eventually(() => expect(document.documentElement.lang).toBe("de"));
  expect(session.state.preferences.value.language).toBe("de");
  session.actions.setLanguage(null);
  await eventually(() => expect(document.documentElement.lang).toBe("en"));
});

it("offers the sound again once a call has taken it, and plays on if the browser does", () => {
  const element = document.createElement("audio");
  const paused = vi.spyOn(element, "paused", "get").mockReturnValue(false);
  vi.spyOn(element, "play").mockResolvedValue();
  const { state, actions } = session;
  open();
  receive(hello());
  session.attachSound(element);
  actions.start();
  paused.mockReturnValue(true);
  element.dispatchEvent(new Event("pause"));
  expect([state.isSoundOn.value, state.isStartOffered.value]).toEqual([false, true]);
  expect(peer().sent.at(-1)).toMatchObject({ type: "want", sound: false });
  expect(state.preferences.value.sound).toBe(true);
  paused.mockReturnValue(false);
  element.dispatchEvent(new Event("play"));
  expect([state.isSoundOn.value, state.isStartOffered.value]).toEqual([true, false]);
  expect(peer().sent.at(-1)).toMatchObject({ type: "want", sound: true });
});
