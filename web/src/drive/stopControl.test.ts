import { signal } from "@preact/signals";
import { beforeEach, expect, it, vi } from "vitest";
import type { StateIn } from "../messages";
import { ServerClock } from "../serverClock";
import { eventually } from "../testing/eventually";
import { pageSentence, says } from "../words/said";
import { StopControl } from "./stopControl";

let done: string[];
let isOpen: boolean;
let respond: () => Promise<Response>;
const say = vi.fn();
const stopNumber = signal<number | null>(null);
const isConnected = signal(true);
const isStopUnconfirmed = signal(false);
const state = { stopNumber, isConnected, isStopUnconfirmed };
/** Lets posted requests be answered. */
const answers = () => new Promise((resolve) => setTimeout(resolve));
let clock: ServerClock;
let stopControl: StopControl;
/** This press, by both transports. */
const sent = (press: number) => [`stop ${press}`, `api/stop {"client":"uuid","press":${press}}`];

beforeEach(() => {
  done = [];
  isOpen = true;
  respond = async () => new Response('{"stop": 7}');
  say.mockClear();
  stopNumber.value = null;
  isConnected.value = true;
  isStopUnconfirmed.value = false;
  vi.spyOn(performance, "now").mockReturnValue(0);
  let numbers = 0;
  vi.spyOn(Math, "random").mockImplementation(() => ++numbers / 2 ** 53);
  clock = new ServerClock();
  vi.stubGlobal("fetch", (path: string, { body }: RequestInit) => {
    done.push(`${path} ${body}`);
    return respond();
  });
  const link = {
    sendState(message: StateIn) {
      done.push("press" in message ? `stop ${message.press}` : message.type);
      return isOpen;
    },
    get clock() {
      return clock;
    },
    beat: "x7-_2A",
  };
  stopControl = new StopControl({
    state,
    link,
    client: () => "uuid",
    letGo: () => done.push("let go"),
    say,
  });
});

it.each([true, false])("stops by both transports in the same task, channel open: %s", (open) => {
  isOpen = open;
  stopControl.stop();
  expect(done).toEqual([...sent(1), "let go"]);
});

it("shows the server's sentence when it refuses", async () => {
  respond = async () => new Response('{"error": "Only whoever drives."}', { status: 403 });
  stopControl.stop();
  await eventually(() => expect(say).toHaveBeenCalledWith(says("Only whoever drives.")));
});

it.each([
  ["nobody answers", () => Promise.reject(new TypeError("Failed to fetch"))],
  ["the server fails", async () => new Response('{"error": "Failed."}', { status: 500 })],
  ["a proxy answers", async () => new Response("Bad gateway", { status: 502 })],
  ["a portal answers", async () => new Response("<h1>Log in</h1>")],
  ["a portal answers anything", async () => new Response("{}")],
])("shows within 2 s that it is not confirmed where %s, and goes on trying", async (_, answer) => {
  respond = answer;
  stopControl.stop();
  await answers();
  stopControl.check(1400);
  expect(isStopUnconfirmed.value).toBe(false);
  done = [];
  stopControl.check(1800);
  expect(isStopUnconfirmed.value).toBe(true);
  expect(done).toEqual(sent(1));
  await answers();
  stopControl.check(5800);
  expect(done).toEqual([...sent(1), ...sent(1)]);
  expect(say).not.toHaveBeenCalled();
  stopNumber.value = 7;
  stopControl.check(6000);
  expect(isStopUnconfirmed.value).toBe(false);
  done = [];
  stopControl.check(20_000);
  expect(done).toEqual([]);
  expect(say).not.toHaveBeenCalled();
});

it("counts each press separately, without delaying the warning", async () => {
  let late = (_: Response) => {};
  respond = () => new Promise((resolve) => (late = resolve));
  stopControl.stop();
  const answerFirst = late;
  vi.spyOn(performance, "now").mockReturnValue(1000);
  done = [];
  stopControl.stop();
  expect(done).toEqual([...sent(2), "let go"]);
  answerFirst(new Response('{"stop": 7}'));
  await answers();
  stopControl.check(1800);
  expect(isStopUnconfirmed.value).toBe(true);
  late(new Response('{"stop": 8}'));
  await answers();
  stopControl.check(2000);
  expect(isStopUnconfirmed.value).toBe(false);
});

it("gives up after 30 s, on a new connection too, and still asks to press again", () => {
  respond = () => new Promise(() => {});
  stopControl.stop();
  done = [];
  stopControl.check(30_000);
  vi.spyOn(performance, "now").mockReturnValue(30_000);
  stopControl.connected();
  expect([done, isStopUnconfirmed.value]).toEqual([[], true]);
});

it.each([
  ["the room is silent", true, null],
  ["the room tells of an earlier stop", true, 3],
  ["there is no connection", false, 7],
])("says that it was taken, by the answer, where %s", async (_, connected, inForce) => {
  stopNumber.value = inForce;
  isConnected.value = connected;
  stopControl.stop();
  await answers();
  stopControl.check(400);
  expect(say).not.toHaveBeenCalled();
  stopControl.check(600);
  expect(say).toHaveBeenCalledExactlyOnceWith("Your Stop has arrived.");
  stopControl.check(5000);
  expect([say.mock.calls.length, isStopUnconfirmed.value]).toEqual([1, false]);
});

it("shows no notice if the room state has this stop, as the card shows it", async () => {
  stopControl.stop();
  await answers();
  stopNumber.value = 7;
  stopControl.check(200);
  stopControl.check(5000);
  expect(say).not.toHaveBeenCalled();
});

it("is also sent over a new connection, unless the server has it", async () => {
  respond = () => Promise.reject(new TypeError("Failed to fetch"));
  stopControl.connected();
  expect(done).toEqual([]);
  stopControl.stop();
  done = [];
  respond = async () => new Response('{"stop": 7}');
  stopControl.connected();
  expect(done).toEqual(sent(1));
  await answers();
  stopControl.connected();
  expect(done).toHaveLength(2);
});

it("stops sending once the server itself refuses", async () => {
  respond = async () => new Response('{"error": "Too often."}', { status: 429 });
  stopControl.stop();
  await answers();
  done = [];
  stopControl.check(2000);
  expect([done, isStopUnconfirmed.value]).toEqual([[], false]);
});

it("continues with the newest press if the server refuses an earlier one", async () => {
  respond = async () => new Response('{"error": "Too often."}', { status: 429 });
  stopControl.stop();
  respond = () => new Promise(() => {});
  stopControl.stop();
  await answers();
  done = [];
  stopControl.check(2000);
  expect([done, isStopUnconfirmed.value]).toEqual([sent(2), true]);
  expect(say).not.toHaveBeenCalled();
});

it("releases by the channel, with the number, the server's time and the newest beat", () => {
  const sendState = vi.fn(() => true);
  clock.add({ sentMs: 0, receivedMs: 0, serverMs: 1_000_000 });
  vi.spyOn(performance, "now").mockReturnValue(500);
  stopNumber.value = 7;
  const link = { sendState, clock, beat: "x7-_2A" };
  new StopControl({
    state,
    link,
    client: () => "uuid",
    letGo: () => {},
    say,
  }).release();
  expect(sendState).toHaveBeenCalledExactlyOnceWith({
    type: "release",
    stop: 7,
    sent_server_ms: 1_000_500,
    beat: "x7-_2A",
  });
  expect(done).toEqual([]);
});

it("releases by HTTP if no channel is open or the clocks are not aligned", () => {
  stopNumber.value = 7;
  stopControl.release();
  clock.add({ sentMs: 0, receivedMs: 0, serverMs: 1_000_000 });
  isOpen = false;
  stopControl.release();
  const posted = 'api/release {"client":"uuid","stop":7}';
  expect(done).toEqual([posted, "release", posted]);
});

it("says why it could not release", async () => {
  stopNumber.value = 7;
  respond = async () => new Response('{"error": "Only whoever drives."}', { status: 403 });
  stopControl.release();
  await eventually(() => expect(say).toHaveBeenLastCalledWith(says("Only whoever drives.")));
  respond = () => Promise.reject(new TypeError("Failed to fetch"));
  stopControl.release();
  await eventually(() => expect(say).toHaveBeenLastCalledWith(pageSentence("link.unreachable")));
});

it("shows nobody the text of a bug in the page", async () => {
  stopNumber.value = 7;
  respond = async () => ({}) as Response;
  stopControl.release();
  await answers();
  expect(say).not.toHaveBeenCalled();
});

it("releases nothing without a stop in force", () => {
  stopControl.release();
  expect(done).toEqual([]);
});
