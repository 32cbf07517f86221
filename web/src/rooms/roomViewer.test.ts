import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Receivers } from "../measure/report";
import type { Seat, ViewerInfo } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { hello, room, seat, sentToRoom, told, viewer } from "../testing/messages";
import { said as inWords, pageSentence, says } from "../words/said";
import { RoomViewer } from "./roomViewer";
import type { WatchOptions } from "./watch";

/** Replaces the LiveKit rooms; the test controls them. */
const watch = vi.hoisted(() => ({
  options: null as WatchOptions | null,
  hasRoom: false,
  offer: vi.fn<(seats: Seat[]) => void>(),
  rest: vi.fn(),
  resume: vi.fn(),
  leave: vi.fn(),
  check: vi.fn(),
}));

vi.mock("./watch", () => ({
  Watch: class {
    constructor(options: WatchOptions) {
      Object.assign(watch, { options, hasRoom: false });
    }
    get hasRoom() {
      return watch.hasRoom;
    }
    offer = watch.offer;
    rest = watch.rest;
    resume = watch.resume;
    leave() {
      watch.hasRoom = false;
      watch.leave();
    }
    check = watch.check;
  },
}));

const NOTHING: Receivers = { sound: null, picture: null };

let state: State;
let away: RoomViewer;
let link: { connect: () => void; close: () => void };
let shown: string[];
let said: string[];
/** The queue requests, and the server's answers to them and to a renewal of the seat. */
let asked: string[];
/** The last name sent to the queue, and for each goodbye, whether it survives the page. */
let named: string | undefined;
let left: (boolean | undefined)[];
let answer: () => Response;
let renewed: () => Response;
let renewals: number;

beforeEach(() => {
  vi.useFakeTimers();
  vi.clearAllMocks();
  vi.spyOn(Math, "random").mockReturnValue(0.5);
  state = createState(loadPreferences(null));
  [shown, said, asked, left] = [[], [], [], []];
  named = undefined;
  answer = () => json(viewer(7, { role: "queued", place: 3, wait_s: 150 }));
  vi.stubGlobal("document", { hidden: false, documentElement: { dataset: {} } });
  renewals = 0;
  renewed = () => new Response(JSON.stringify(sentToRoom({ rooms: [seat("two")] })));
  vi.stubGlobal("fetch", async (path: string, init: { body: string; keepalive?: boolean }) => {
    const body = JSON.parse(init.body);
    if (path === "api/seat") {
      if (body.leaves) left.push(init.keepalive);
      else renewals++;
      return renewed();
    }
    asked.push(body.wants);
    named = body.name;
    return answer();
  });
  link = { connect: vi.fn(), close: vi.fn(() => away.linkChanged({ is: "closed" })) };
  away = new RoomViewer({
    state,
    link,
    client: () => "client",
    wants: () => ({ sound: true, picture: true }),
    size: () => "640x480",
    show: () => shown.push("room"),
    enterRoom: (now) => {
      state.room.value = now;
    },
    say: (what) => said.push(typeof what === "string" ? what : inWords(what)),
  });
});

afterEach(() => {
  vi.clearAllTimers();
});

function json(line: ViewerInfo): Response {
  return new Response(JSON.stringify(line));
}

function events() {
  if (!watch.options) throw new Error("nothing is watched");
  return watch.options.events;
}

/** The page was sent to a room, which now plays. */
function play(): void {
  away.sent(sentToRoom());
  watch.hasRoom = true;
  events().show(NOTHING);
  events().plays(true);
}

function tell(...lines: ViewerInfo[]): void {
  events().told(told({ ...room({ operator: 2 }), viewers: lines }));
}

/** The robot's server sends a message, and the page has checked once. */
function hear(): void {
  tell();
  vi.advanceTimersByTime(50);
}

const picture = { frames: [] as object[] };
const receiver = {
  getSynchronizationSources: () => picture.frames,
} as unknown as RTCRtpReceiver;

/** The robot's server accepts this page: first the peer, then the hello. */
function comeTo(number: number): void {
  picture.frames = [];
  away.linkChanged({ is: "connecting", reason: null });
  away.arrives(receiver, () => shown.push("server"));
  state.hello.value = hello({ viewer: number });
  away.linkChanged({ is: "connected" });
}

it("reports a silent robot's server while the room plays on", () => {
  play();
  tell();
  vi.advanceTimersByTime(2400);
  expect(state.link.value).toEqual({ is: "connected" });
  vi.advanceTimersByTime(200);
  expect(state.link.value.is).toBe("silent");
  hear();
  expect(state.link.value).toEqual({ is: "connected" });
});

it("watches where it is sent, and is connected once a room plays", () => {
  away.sent(sentToRoom());
  expect(watch.offer.mock.lastCall?.[0]).toEqual([seat("one"), seat("two")]);
  expect(state.link.value).toEqual({ is: "connecting", reason: null });
  expect(state.isInRoom.value).toBe(true);
  events().show(NOTHING);
  events().plays(true);
  expect(state.link.value).toEqual({ is: "connected" });
  expect(away.isOnScreen).toBe(true);
});

it("shows the broadcast room state with this page among the observers", () => {
  play();
  tell(viewer(2, { role: "operator" }));
  expect(state.me.value).toMatchObject({ id: 0, role: "observer" });
  expect(state.operator.value?.name).toBe("Bob");
  expect(state.watching.value).toBe(1000);
});

it("renews its tokens before they expire, while the room plays on", async () => {
  play();
  await vi.advanceTimersByTimeAsync(230_000);
  expect(renewals).toBe(0);
  await vi.advanceTimersByTimeAsync(20_000);
  expect(renewals).toBe(1);
  await vi.advanceTimersByTimeAsync(250_000);
  expect(renewals).toBe(2);
  expect(link.connect).not.toHaveBeenCalled();
  expect(watch.offer.mock.lastCall?.[0]).toEqual([seat("two")]);
  hear();
  expect(state.link.value).toEqual({ is: "connected" });
});

it("gives back its seat, if any, when the page is closed", () => {
  away.giveUp();
  expect(left).toEqual([]);
  play();
  away.giveUp();
  expect(left).toEqual([true]);
});

it("sends its name, if any, to the queue", async () => {
  play();
  tell(viewer(2, { role: "operator" }));
  away.ask("join");
  expect(named).toBeUndefined();
  state.preferences.value = { ...state.preferences.value, name: "Eve" };
  tell(viewer(2, { role: "operator" }), viewer(7, { role: "queued" }));
  await vi.advanceTimersByTimeAsync(6000);
  expect(asked.at(-1)).toBe("stay");
  expect(named).toBe("Eve");
});

it("backs off from a server that is too busy for new tokens", async () => {
  play();
  renewed = () => new Response(JSON.stringify({ error: "Busy." }), { status: 503 });
  await vi.advanceTimersByTimeAsync(250_000);
  expect(renewals).toBe(1);
  hear();
  expect(state.link.value).toEqual({ is: "connected" });
  await vi.advanceTimersByTimeAsync(30_000);
  expect(renewals).toBe(2);
  expect(link.connect).not.toHaveBeenCalled();
});

it("learns from the robot's server why it may not stay", async () => {
  play();
  const said = { error: "The host has sent you away.", ended: true };
  renewed = () => new Response(JSON.stringify(said), { status: 403 });
  await vi.advanceTimersByTimeAsync(250_000);
  expect(link.connect).toHaveBeenCalledOnce();
});

it("stops asking the server once a room plays again", async () => {
  play();
  away.linkChanged({ is: "connecting", reason: says("The server cannot be reached.") });
  await vi.advanceTimersByTimeAsync(0);
  expect(link.close).toHaveBeenCalledOnce();
  expect(state.link.value).toEqual({ is: "connected" });
});

describe("when no room plays", () => {
  it("says so and asks the robot's server, first at once, then less often", () => {
    play();
    events().plays(false);
    expect(state.link.value).toEqual({
      is: "connecting",
      reason: pageSentence("link.stood"),
    });
    events().failed();
    expect(state.link.value).toMatchObject({ is: "waiting", reason: pageSentence("link.full") });
    vi.advanceTimersByTime(0);
    expect(link.connect).toHaveBeenCalledTimes(1);
    events().failed();
    vi.advanceTimersByTime(900);
    expect(link.connect).toHaveBeenCalledTimes(1);
    vi.advanceTimersByTime(200);
    expect(link.connect).toHaveBeenCalledTimes(2);
  });

  it("shows what the robot's server says", () => {
    play();
    events().plays(false);
    events().failed();
    const full = { is: "waiting", retryAtMs: 9, reason: says("All 8 places are taken.") } as const;
    away.linkChanged(full);
    expect(state.link.value).toEqual(full);
    expect(link.close).not.toHaveBeenCalled();
  });

  it("returns to the rooms once there are some", () => {
    play();
    events().plays(false);
    watch.hasRoom = false;
    events().failed();
    away.sent(sentToRoom());
    expect(watch.offer).toHaveBeenCalledTimes(2);
    expect(state.link.value).toEqual({ is: "connecting", reason: null });
  });

  it("shows other sites' pages if there are no rooms", () => {
    away.sent(sentToRoom({ rooms: [], links: ["https://watch.example.org"] }));
    expect(state.links.value).toEqual(["https://watch.example.org"]);
    expect(state.link.value).toMatchObject({ is: "waiting", reason: pageSentence("link.full") });
  });
});

describe("the queue", () => {
  it("is joined by HTTP, and the place is kept every five seconds", async () => {
    play();
    tell(viewer(2, { role: "operator" }));
    expect(away.ask("join")).toBe(true);
    await vi.advanceTimersByTimeAsync(0);
    expect(state.me.value).toMatchObject({ id: 7, role: "queued", place: 3 });
    expect(state.drivingTurn.value).toBeNull();
    for (let i = 0; i < 20; i++) {
      await vi.advanceTimersByTimeAsync(1000);
      tell(viewer(7, { role: "queued", place: 2, wait_s: 100 }));
    }
    expect(asked.filter((one) => one === "stay")).toHaveLength(4);
    expect(state.me.value?.place).toBe(2);
  });

  it("is left by HTTP", async () => {
    play();
    tell(viewer(2, { role: "operator" }));
    away.ask("join");
    await vi.advanceTimersByTimeAsync(0);
    answer = () => json(viewer(7));
    away.ask("leave");
    await vi.advanceTimersByTimeAsync(20_000);
    expect(asked).toEqual(["join", "leave"]);
    expect(state.me.value).toMatchObject({ id: 0, role: "observer" });
  });

  it("says why it cannot be joined", async () => {
    play();
    tell();
    const error = "Only invited people drive this robot. Ask its host for a link.";
    answer = () => new Response(JSON.stringify({ error }), { status: 403 });
    away.ask("join");
    await vi.advanceTimersByTimeAsync(0);
    expect(said).toEqual([error]);
    expect(state.me.value?.role).toBe("observer");
  });

  it("place is lost when the broadcast queue lacks this page", async () => {
    play();
    tell();
    away.ask("join");
    await vi.advanceTimersByTimeAsync(1000);
    tell(viewer(2, { role: "operator" }));
    expect(state.me.value?.id).toBe(7);
    await vi.advanceTimersByTimeAsync(3000);
    tell(viewer(2, { role: "operator" }));
    expect(state.me.value).toMatchObject({ id: 0, role: "observer" });
  });
});

describe("for its turn", () => {
  const soon = viewer(7, { role: "queued", place: 1, wait_s: 10 });

  /** The page waits, and its turn comes near. */
  async function near(): Promise<void> {
    play();
    tell(viewer(2, { role: "operator" }));
    away.ask("join");
    await vi.advanceTimersByTimeAsync(0);
    expect(link.connect).not.toHaveBeenCalled();
    tell(soon);
  }

  it("connects to the robot's server, and keeps the room's picture until the next arrives", async () => {
    await near();
    expect(link.connect).toHaveBeenCalledOnce();
    tell(soon);
    expect(link.connect).toHaveBeenCalledOnce();
    comeTo(7);
    expect(state.isInRoom.value).toBe(false);
    vi.advanceTimersByTime(500);
    expect(shown).toEqual(["room"]);
    picture.frames = [{}];
    vi.advanceTimersByTime(50);
    expect(shown).toEqual(["room", "server"]);
    expect(watch.rest).toHaveBeenCalledOnce();
    expect(away.ask("here")).toBe(false);
  });

  it("shows the server's picture by the time it drives", async () => {
    await near();
    comeTo(7);
    state.room.value = room({ operator: 7 });
    vi.advanceTimersByTime(50);
    expect(shown).toEqual(["room", "server"]);
  });

  it("stays in the room if it leaves the queue meanwhile", async () => {
    await near();
    answer = () => json(viewer(7));
    away.ask("leave");
    await vi.advanceTimersByTimeAsync(0);
    expect(link.close).toHaveBeenCalledOnce();
  });

  /** The page drives, and the turn ends. */
  async function driven(then: ViewerInfo): Promise<void> {
    await near();
    comeTo(7);
    picture.frames = [{}];
    state.room.value = room({ operator: 7 });
    vi.advanceTimersByTime(60_000);
    expect(watch.resume).not.toHaveBeenCalled();
    state.room.value = { ...room({ operator: 2 }), viewers: [then] };
    vi.advanceTimersByTime(50);
  }

  it("returns afterwards, once the room's picture has arrived", async () => {
    await driven(viewer(7));
    expect(watch.resume).toHaveBeenCalledOnce();
    expect(link.close).not.toHaveBeenCalled();
    events().show(NOTHING);
    await vi.advanceTimersByTimeAsync(0);
    expect(link.close).toHaveBeenCalledOnce();
    expect(shown).toEqual(["room", "server", "room"]);
    expect(state.me.value).toMatchObject({ id: 0, role: "observer" });
    hear();
    expect(state.link.value).toEqual({ is: "connected" });
    await vi.advanceTimersByTimeAsync(3000);
    expect(renewals, "its tokens have aged meanwhile").toBe(1);
  });

  it("secures its next place before it returns", async () => {
    const again = viewer(7, { role: "queued", place: 2, wait_s: 90 });
    answer = () => json(again);
    await driven(again);
    asked.length = 0;
    vi.mocked(link.close).mockImplementation(() => asked.push("closed"));
    events().show(NOTHING);
    await vi.advanceTimersByTimeAsync(0);
    expect(asked).toEqual(["stay", "closed"]);
    expect(state.me.value).toMatchObject({ id: 7, role: "queued" });
  });

  it("stays with the server if the room has ended meanwhile", async () => {
    await near();
    comeTo(7);
    picture.frames = [{}];
    vi.advanceTimersByTime(50);
    watch.hasRoom = false;
    state.room.value = room({ watching: [7] });
    vi.advanceTimersByTime(10_000);
    expect(link.close).not.toHaveBeenCalled();
    expect(watch.resume).not.toHaveBeenCalled();
  });
});

it("moves to the robot's server for good when that has a place", () => {
  play();
  vi.advanceTimersByTime(110_000);
  comeTo(9);
  picture.frames = [{}];
  vi.advanceTimersByTime(50);
  expect(shown).toEqual(["room", "server"]);
  expect(watch.leave).toHaveBeenCalledOnce();
  expect(watch.rest).not.toHaveBeenCalled();
  state.room.value = room({ watching: [9] });
  vi.advanceTimersByTime(60_000);
  expect(link.close).not.toHaveBeenCalled();
});
