import { beforeEach, expect, it, vi } from "vitest";
import type { Drive } from "../messages";
import { CommandSender, type Controls } from "./commandSender";

const HOLDING: Controls = {
  motion: { linear: 1, angular: -1 },
  held: true,
  speed: "fast",
  axes: { pan: 0.5 },
};
const EMPTY: Controls = {
  motion: { linear: 0, angular: 0 },
  held: false,
  speed: "slow",
  axes: {},
};

let sent: (Drive & { urgent: boolean })[];
let serverMs: number | null;
let controls: Controls;
let waitingBytes: number;
let linkBps: number;
/** Messages stay buffered until the end of the task, as in a browser. */
let saidBytes: number;
const hung = vi.fn();
let sender: CommandSender;

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  serverMs = 5000;
  controls = EMPTY;
  waitingBytes = 0;
  linkBps = 5_000_000;
  saidBytes = 0;
  hung.mockReset();
  sender = new CommandSender({
    controls: () => controls,
    serverMs: () => serverMs,
    beat: () => "x7-_2A",
    seenServerMs: () => 4900,
    uplink: () => ({ linkBps, waitingBytes: waitingBytes + saidBytes, queuedMs: 0 }),
    hung,
    send: (drive, urgent) => {
      sent.push({ ...drive, urgent });
      saidBytes += 100;
      setTimeout(() => {
        saidBytes = 0;
      });
    },
  });
});

/** How many set-points are sent in this time. */
function sentIn(ms: number): number {
  const before = sent.length;
  vi.advanceTimersByTime(ms);
  return sent.length - before;
}

it("sends nothing before a turn begins and after it has ended", () => {
  sender.send();
  sender.repeat();
  expect(sentIn(1000)).toBe(0);
  sender.begin(7, 25);
  sender.repeat();
  sender.end();
  expect(sentIn(1000)).toBe(0);
});

it("sends a complete set-point at once when a turn begins", () => {
  sender.begin(7, 25);
  expect(sent).toEqual([
    {
      type: "drive",
      seq: 0,
      turn: 7,
      sent_server_ms: 5000,
      linear: 0,
      angular: 0,
      held: false,
      speed: "slow",
      seen_server_ms: 4900,
      axes: {},
      beat: "x7-_2A",
      urgent: false,
    },
  ]);
});

it("sends at the requested rate while something is held", () => {
  controls = HOLDING;
  sender.begin(7, 50);
  expect(sentIn(2000)).toBe(100);
});

it("sends less often over a thin link while nothing is held", () => {
  linkBps = 33_600;
  sender.begin(7, 50);
  vi.advanceTimersByTime(600);
  expect(sentIn(3000)).toBe(30);
});

it("sends 20 times a second while nothing is held, and is at full rate from the next press on", () => {
  sender.begin(7, 50);
  vi.advanceTimersByTime(600);
  expect(sentIn(1000)).toBe(20);
  controls = HOLDING;
  sender.send();
  expect(sentIn(200)).toBe(10);
});

it("does not count its own repeated messages as a backlog", () => {
  controls = HOLDING;
  sender.begin(7, 50);
  sender.repeatAtOnce();
  expect(sentIn(2000)).toBeGreaterThanOrEqual(100);
});

it("never sends what was held before the page hung", () => {
  const clock = vi.spyOn(performance, "now");
  let nowMs = 0;
  clock.mockImplementation(() => nowMs);
  controls = HOLDING;
  hung.mockImplementation(() => {
    controls = EMPTY;
  });
  sender.begin(7, 50);
  nowMs = 400;
  vi.advanceTimersToNextTimer();
  vi.advanceTimersByTime(20);
  expect(hung).not.toHaveBeenCalled();
  sent = [];
  nowMs = 1000;
  vi.advanceTimersByTime(20);
  expect(hung).toHaveBeenCalledOnce();
  expect(sent.map((drive) => drive.held)).toEqual([false]);
});

it("sends 20 times a second as soon as set-points wait to be sent", () => {
  controls = HOLDING;
  sender.begin(7, 50);
  vi.advanceTimersByTime(500);
  waitingBytes = 400;
  vi.advanceTimersByTime(20);
  expect(sentIn(1000)).toBe(20);
});

it("numbers its commands in strictly ascending order, across turns too", () => {
  sender.begin(7, 25);
  vi.advanceTimersByTime(100);
  sender.repeat();
  sender.begin(8, 50);
  vi.advanceTimersByTime(100);
  expect(sent.map((drive) => drive.seq)).toEqual(sent.map((_, index) => index));
  expect(sent.at(-1)?.turn).toBe(8);
});

it("reads what is held at the moment of sending", () => {
  sender.begin(7, 25);
  controls = HOLDING;
  sender.send();
  expect(sent.at(-1)).toMatchObject({ linear: 1, angular: -1, held: true, axes: { pan: 0.5 } });
});

it("waits until the clocks are aligned", () => {
  serverMs = null;
  sender.begin(7, 25);
  vi.advanceTimersByTime(200);
  expect(sent).toEqual([]);
  serverMs = 6000;
  vi.advanceTimersByTime(40);
  expect(sent).toHaveLength(1);
});

it("sends a release three times within 100 ms, ahead of any backlog", () => {
  sender.begin(7, 20);
  sent = [];
  sender.repeat();
  expect(sent.filter((drive) => drive.urgent)).toHaveLength(1);
  vi.advanceTimersByTime(100);
  expect(sent.filter((drive) => drive.urgent)).toHaveLength(3);
});

it("sends it three times before the task ends if the page may not run again", () => {
  sender.begin(7, 20);
  sent = [];
  sender.repeatAtOnce();
  expect(sent.filter((drive) => drive.urgent)).toHaveLength(3);
});

it("sends the first move of a stick at once, and further ones with the set-points", () => {
  controls = HOLDING;
  sender.begin(7, 50);
  vi.advanceTimersByTime(1007);
  sent = [];
  sender.deflected();
  expect(sent).toHaveLength(1);
  for (let atMs = 0; atMs < 1000; atMs += 10) {
    vi.advanceTimersByTime(10);
    sender.deflected();
  }
  // The server takes 60 a second.
  expect(sent.length).toBeGreaterThanOrEqual(50);
  expect(sent.length).toBeLessThanOrEqual(60);
});
