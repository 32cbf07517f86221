import { signal } from "@preact/signals";
import { beforeEach, expect, it, vi } from "vitest";
import { ServerClock } from "../serverClock";
import { eventually } from "../testing/eventually";
import { ours, says } from "../words/said";
import { StopControl } from "./stopControl";

let done: string[];
let isOpen: boolean;
let respond: () => Promise<Response>;
const say = vi.fn();
const stopNumber = signal<number | null>(null);
let clock: ServerClock;
let stopControl: StopControl;

beforeEach(() => {
  done = [];
  isOpen = true;
  respond = async () => new Response('{"stop": 7}');
  say.mockClear();
  stopNumber.value = null;
  clock = new ServerClock();
  vi.stubGlobal("fetch", (path: string, { body }: RequestInit) => {
    done.push(`${path} ${body}`);
    return respond();
  });
  const link = {
    sendState(message: { type: string }) {
      done.push(message.type);
      return isOpen;
    },
    get clock() {
      return clock;
    },
    beat: "x7-_2A",
  };
  stopControl = new StopControl({
    state: { stopNumber },
    link,
    client: () => "uuid",
    letGo: () => done.push("let go"),
    say,
  });
});

it.each([true, false])("stops by both ways before the task ends, channel open: %s", (open) => {
  isOpen = open;
  stopControl.stop();
  expect(done).toEqual(["stop", 'api/stop {"client":"uuid"}', "let go"]);
});

it("says the server's sentence when it refuses", async () => {
  respond = async () => new Response('{"error": "Only whoever drives."}', { status: 403 });
  stopControl.stop();
  await eventually(() => expect(say).toHaveBeenCalledWith(says("Only whoever drives.")));
});

it("says so when nobody answers, unless the stop is known to be latched", async () => {
  respond = () => Promise.reject(new TypeError("Failed to fetch"));
  stopControl.stop();
  await eventually(() => expect(say).toHaveBeenCalledWith(expect.stringContaining("by hand")));
  say.mockClear();
  stopNumber.value = 7;
  stopControl.stop();
  await new Promise((resolve) => setTimeout(resolve));
  expect(say).not.toHaveBeenCalled();
});

it("releases by the channel, with the number, the server's time and the newest beat", () => {
  const sendState = vi.fn(() => true);
  clock.add({ sentMs: 0, receivedMs: 0, serverMs: 1_000_000 });
  vi.spyOn(performance, "now").mockReturnValue(500);
  stopNumber.value = 7;
  const link = { sendState, clock, beat: "x7-_2A" };
  new StopControl({
    state: { stopNumber },
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

it("releases by HTTP where no channel is open, or the clocks are not aligned", () => {
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
  await eventually(() => expect(say).toHaveBeenLastCalledWith(ours("link.unreachable")));
});

it("shows nobody the words of a mistake in the page", async () => {
  stopNumber.value = 7;
  respond = async () => ({}) as Response;
  stopControl.release();
  await new Promise((resolve) => setTimeout(resolve));
  expect(say).not.toHaveBeenCalled();
});

it("releases nothing where nothing is latched", () => {
  stopControl.release();
  expect(done).toEqual([]);
});
