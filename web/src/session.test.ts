// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Session } from "./actions";
import type { PeerEvents } from "./link/peer";
import {
  type Ended,
  MAX_NAME_CHARS,
  MAX_TASK_CHARS,
  type StateIn,
  type StateOut,
} from "./messages";
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

  /** Replaces the browser's peer connection, and answers every ping at once. */
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

/** Replaces the viewer of LiveKit rooms, which is loaded on demand. */
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

/** Isolates the tests: the previous session's identity channel stays silent. */
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

/** The turns of the set-points sent over the newest peer. */
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
  vi.spyOn(LateWords.prototype, "loadOnce").mockReturnValue(words);
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

  /** Sent in the same task: whether anything is held, and the speed ahead. */
  function said(during: () => void): unknown[] {
    const before = peer().rows.length;
    during();
    const drives = peer()
      .rows.slice(before)
      .filter(([type]) => type === "drive");
    return drives.map(([, , , , linear, , held]) => [held, linear]);
  }

  it("state in each command whether anything is held", () => {
    expect(said(() => session.actions.press("a", "forward"))).toEqual([[true, 1]]);
    expect(said(() => session.actions.press("b", "back"))).toEqual([[true, 0]]);
    session.actions.release("b");
    expect(said(() => session.actions.release("a"))).toEqual([[false, 0]]);
  });

  it("send a release three times within 100 ms", () => {
    session.actions.press("a", "forward");
    session.actions.release("a");
    // Without the repeats there would be only one in this time, after 50 ms.
    expect(said(() => vi.advanceTimersByTime(95)).length).toBeGreaterThanOrEqual(2);
  });

  it("send it three times before the end of the task in which the page loses the input", () => {
    session.actions.press("a", "forward");
    const words = said(() => window.dispatchEvent(new Event("pagehide")));
    expect(words.length).toBeGreaterThanOrEqual(3);
    expect(new Set(words.map(String))).toEqual(new Set(["false,0"]));
  });

  it("send the chosen speed at once", () => {
    for (const speed of ["fast", "slow"] as const) {
      session.actions.setSpeed(speed);
      expect(peer().rows.at(-1)?.[7]).toBe(speed);
    }
  });

  it("end with the turn, whose seconds the page counts down", () => {
    receive(room({ operator: 1, number: 7, endsMs: performance.now() + 30_000 }));
    vi.advanceTimersByTime(1000);
    const leftS = session.state.secondsLeft.value ?? 0;
    vi.advanceTimersByTime(1000);
    expect(session.state.secondsLeft.value).toBe(leftS - 1);
    expect(leftS).toBe(29);
  });

  it("are empty from a stop until the first press after its release", () => {
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

  it("send Stop over the channel before anything else", () => {
    const fetching = vi.fn(() => Promise.reject(new TypeError("Failed to fetch")));
    vi.stubGlobal("fetch", fetching);
    session.actions.press("a", "forward");
    session.actions.stop();
    expect(peer().sent.at(-1)).toEqual({ type: "stop", press: expect.any(Number) });
    expect(fetching).toHaveBeenCalledOnce();
    expect(session.state.held.value.size).toBe(0);
  });

  it("report nothing of a picture that is switched off", () => {
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

it("cuts a name to the server's length", () => {
  open();
  session.actions.setName(` ${"x".repeat(100)} `);
  const name = "x".repeat(MAX_NAME_CHARS);
  expect(peer().sent).toContainEqual({ type: "name", name });
  expect(session.state.preferences.value.name).toBe(name);
});

it("says in each turn what the user does, and afterwards that it is not to be used", () => {
  const tape = { running: true, why: says("."), can_disown: true, asks_task: true };
  open();
  receive(hello({ viewer: 1 }), { ...room({ waiting: [1], operator: 2 }), tape });
  session.actions.setTask(` ${"x".repeat(200)} `);
  expect(peer().sent).not.toContainEqual(expect.objectContaining({ type: "task" }));
  receive({ ...room({ operator: 1, number: 7 }), tape });
  const text = "x".repeat(MAX_TASK_CHARS);
  expect(peer().sent).toContainEqual({ type: "task", turn: 7, text });
  session.actions.disown();
  receive({ ...room({ operator: 2, number: 8 }), tape });
  session.actions.disown();
  session.actions.disown();
  const disowned = peer().sent.filter((one) => one.type === "disown");
  expect(disowned).toEqual([{ type: "disown", turn: 7 }]);
});

it("delivers a click although the page moves under the pointer", () => {
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

it("keeps the viewer's own entry in the room state while the connection is lost", () => {
  open();
  receive(hello({ viewer: 1 }), room({ operator: 1 }));
  peer().events.lost(says("The connection was lost."), null);
  vi.advanceTimersByTime(0);
  expect(session.state.link.value.is).toBe("connecting");
  expect(session.state.me.value?.role).toBe("operator");
});

it("asks for no larger picture than its window shows, except for a photo", async () => {
  let resize = (_entries: object[]) => {};
  class Observer {
    constructor(told: typeof resize) {
      resize = told;
    }
    observe(): void {}
    disconnect(): void {}
  }
  vi.stubGlobal("ResizeObserver", Observer);
  session = startSession();
  await vi.advanceTimersByTimeAsync(0);
  open();
  receive(hello());
  const video = document.createElement("video");
  session.attachPicture(video);
  resize([{ contentRect: { width: 300, height: 225 } }]);
  expect(peer().sent.at(-1)).toMatchObject({ type: "want", size: "640x480" });
  vi.advanceTimersByTime(5000);
  expect(peer().sent.at(-1)).toMatchObject({ type: "want", size: "320x240" });
  const photo = session.forPhoto(async () => peer().sent.at(-1));
  video.dispatchEvent(new Event("resize"));
  expect(await photo).toMatchObject({ type: "want", size: "640x480" });
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

it("keeps the report of what is served only for the connection it describes", () => {
  open();
  receive(hello(), served({ link_bps: 2_000_000 }));
  expect(session.state.served.value).toEqual(served({ link_bps: 2_000_000 }));
  peer().events.lost(says("The connection was lost."), null);
  vi.advanceTimersByTime(400);
  peer().events.answered();
  expect(session.state.served.value).toBeNull();
});

it("sends less if the server says that the link is slow", async () => {
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

it("loads the server's words once picture and sound have arrived, or are late", () => {
  const loadOnce = vi.spyOn(LateWords.prototype, "loadOnce");
  const { state, actions } = session;
  actions.setSound(true);
  open();
  receive(hello({ viewer: 1 }));
  const facts = { ...state.facts.value, pictureMs: 40 };
  state.facts.value = facts;
  expect(loadOnce).not.toHaveBeenCalled();
  state.facts.value = { ...facts, soundMs: 80 };
  expect(loadOnce).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(3900);
  expect(loadOnce).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(200);
  expect(loadOnce).toHaveBeenCalledTimes(2);
});

it("loads the server's words at once if the connection is lost, not if the server is only silent", () => {
  const loadOnce = vi.spyOn(LateWords.prototype, "loadOnce");
  session.state.link.value = { is: "silent", sinceMs: 0 };
  expect(loadOnce).not.toHaveBeenCalled();
  session.state.link.value = { is: "closed" };
  expect(loadOnce).toHaveBeenCalledOnce();
});

it("says so if it should acknowledge and this browser cannot", async () => {
  receive(hello({ acknowledge: true }));
  await vi.advanceTimersByTimeAsync(0);
  expect(said(session.state.notice.value?.text)).toContain("cannot say what it has received");
  expect(peers).toHaveLength(1);
});

describe("a page that may not stay", () => {
  const ended = { type: "ended", text: says("The robot is closed."), openings: [] } satisfies Ended;

  it("shows why, stays disconnected, and reconnects on request", () => {
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

  it("reconnects by itself when the robot opens, spread over time", () => {
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

  /** A server with this answer; each request is recorded. */
  function server(status: number, body: object) {
    const asked: string[] = [];
    vi.stubGlobal("fetch", async (path: string) => {
      asked.push(path);
      return new Response(JSON.stringify(body), { status });
    });
    return asked;
  }

  it("is sent to the server before the page connects, and removed from the address by then", async () => {
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

  it("that is invalid shows a lasting message, and the page connects as a guest's", async () => {
    server(403, { error: "This host link has expired." });
    window.location.hash = "#host=old";
    peers.length = 0;
    session = startSession();
    await vi.advanceTimersByTimeAsync(10_000);
    expect(said(session.state.entryProblem.value)).toBe("This host link has expired.");
    expect(peers.length).toBeGreaterThan(0);
  });
});

it("starts where the browser allows no cookies, and so no channel between its tabs", async () => {
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

  it("no key drives, stops or speaks, and no secret in the address is sent to the server", async () => {
    const fetching = vi.fn();
    vi.stubGlobal("fetch", fetching);
    // The session that every test here starts with is in no frame, and would take it.
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

  it("stores nothing in the browser, and reads nothing from it", async () => {
    window.localStorage.setItem("wax-preferences", '{"picture": false, "name": "Ada"}');
    session = startSession();
    expect(session.state.preferences.value).toMatchObject({ picture: true, name: "" });
    session.actions.setSound(true);
    expect(window.localStorage.getItem("wax-preferences")).toContain("Ada");
    expect(window.sessionStorage).toHaveLength(0);
  });
});

describe("a notification at one's turn", () => {
  const NEVER = new Promise<never>(() => {});
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

  it("stays on if the browser allows it, until it is switched off", async () => {
    asks("granted");
    expect(await wants(true)).toBe(true);
    expect(session.state.notice.value).toBeNull();
    expect(await wants(false)).toBe(false);
  });

  it("stays off if the browser refuses it, with a reason", async () => {
    asks("denied");
    expect(await wants(true)).toBe(false);
    expect(said(session.state.notice.value?.text)).toContain("shows no notifications");
  });

  it.each([
    ["the browser never says whether it allows it", { requestPermission: () => NEVER }, {}],
    ["its worker never starts", {}, { ready: NEVER }],
  ])("stays off with a reason after 4 s if %s", async (_, notification, worker) => {
    asks("granted");
    Object.assign(Notification, notification);
    Object.assign(navigator.serviceWorker, worker);
    expect(await wants(true)).toBe(false);
    await vi.advanceTimersByTimeAsync(4000);
    expect(said(session.state.notice.value?.text)).toContain("does not answer (Notification)");
    expect(session.state.preferences.value.tells).toBe(false);
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

  it("rings for the operator, and is shown for a while", async () => {
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

  it("ends when the person takes over the robot", () => {
    open();
    receive(hello({ viewer: 2 }), now, asks(1));
    expect(session.state.request.value).toEqual({ asked: "wait" });
    receive({ ...now, aboard: aboard({ mode: "hand", asked: "wait", asks: 1 }) });
    expect(session.state.request.value).toBeNull();
    receive({ ...now, aboard: aboard({ mode: "hand", asked: "left", asks: 2 }) });
    expect(session.state.request.value).toEqual({ asked: "left" });
  });

  it("is shown to observers without a sound", () => {
    const made = vi.fn();
    vi.stubGlobal("AudioContext", made);
    open();
    receive(hello({ viewer: 2 }), now, asks(1));
    expect(made).not.toHaveBeenCalled();
    expect(session.state.request.value).toEqual({ asked: "wait" });
  });
});

describe("a page for which the server is full", () => {
  beforeEach(async () => {
    vi.clearAllMocks();
    Object.assign(away, { isOnScreen: false, made: 0 });
    expect(session.state.link.value.is).toBe("connecting");
    peer().events.sent(sentToRoom());
    await vi.dynamicImportSettled();
  });

  it("loads the viewer of LiveKit rooms, and tells it where to watch each time", async () => {
    expect(away.sent).toHaveBeenCalledWith(sentToRoom());
    session.actions.comeBack();
    peer().events.sent(sentToRoom({ rooms: [] }));
    await vi.dynamicImportSettled();
    expect(away.sent).toHaveBeenCalledTimes(2);
    expect(away.made).toBe(1);
  });

  it("sends queue requests through it, and by its channel once it is the server's viewer", () => {
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

  it("counts down by the room's estimate of the server's clock", () => {
    session.state.isInRoom.value = true;
    vi.advanceTimersByTime(200);
    expect(session.state.serverMs.value).toBe(4000);
  });

  it("gives back its seat when the page is closed", () => {
    window.dispatchEvent(new Event("pagehide"));
    expect(away.giveUp).toHaveBeenCalled();
  });

  it("lets the viewer decide when a peer's picture is shown", () => {
    away.isOnScreen = true;
    session.actions.comeBack();
    peer().events.answered();
    expect(away.arrives).toHaveBeenCalledOnce();
  });

  it("leaves the rooms if it may not stay", () => {
    session.actions.comeBack();
    open();
    receive({ type: "ended", text: says("You were removed."), openings: [] });
    expect(away.leave).toHaveBeenCalledOnce();
  });
});

it("reconnects once with room for the cameras that the server now has", async () => {
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

it("uses the chosen language, and stores the choice", async () => {
  session.actions.setLanguage("de");
  await eventually(() => expect(document.documentElement.lang).toBe("de"));
  expect(session.state.preferences.value.language).toBe("de");
  session.actions.setLanguage(null);
  await eventually(() => expect(document.documentElement.lang).toBe("en"));
});

it("offers the sound again after a call has paused it, and resumes if the browser does", () => {
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
