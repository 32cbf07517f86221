import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Drive } from "../messages";
import { type Controls, Pump } from "./pump";

let sent: (Drive & { urgent: boolean })[];
let serverMs: number | null;
let controls: Controls;
let pump: Pump;

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  serverMs = 5000;
  controls = { motion: { linear: 0, angular: 0 }, speed: "fine", axes: {} };
  pump = new Pump({
    controls: () => controls,
    serverMs: () => serverMs,
    seenServerMs: () => 4900,
    send: (drive, urgent) => sent.push({ ...drive, urgent }),
  });
});

afterEach(() => vi.useRealTimers());

it("sends nothing until a turn begins and nothing after it ended", () => {
  pump.send();
  pump.insist();
  vi.advanceTimersByTime(1000);
  expect(sent).toEqual([]);
  pump.begin(7, 25);
  pump.insist();
  pump.end();
  const count = sent.length;
  vi.advanceTimersByTime(1000);
  expect(sent).toHaveLength(count);
});

it("sends complete set-points at the rate that was asked for, standing still too", () => {
  pump.begin(7, 25);
  vi.advanceTimersByTime(1000);
  expect(sent).toHaveLength(26);
  expect(sent[0]).toEqual({
    type: "drive",
    seq: 0,
    turn: 7,
    sent_server_ms: 5000,
    linear: 0,
    angular: 0,
    speed: "fine",
    seen_server_ms: 4900,
    axes: {},
    urgent: false,
  });
});

it("numbers its commands strictly rising, over turns too", () => {
  pump.begin(7, 25);
  vi.advanceTimersByTime(100);
  pump.insist();
  pump.begin(8, 50);
  vi.advanceTimersByTime(100);
  expect(sent.map((drive) => drive.seq)).toEqual(sent.map((_, index) => index));
  expect(sent.at(-1)?.turn).toBe(8);
});

it("reads what is held at the moment of sending", () => {
  pump.begin(7, 25);
  controls = { motion: { linear: 1, angular: -1 }, speed: "gross", axes: { pan: 0.5 } };
  pump.send();
  expect(sent.at(-1)).toMatchObject({ linear: 1, angular: -1, speed: "gross", axes: { pan: 0.5 } });
});

it("waits until the clocks are aligned", () => {
  serverMs = null;
  pump.begin(7, 25);
  vi.advanceTimersByTime(200);
  expect(sent).toEqual([]);
  serverMs = 6000;
  vi.advanceTimersByTime(40);
  expect(sent).toHaveLength(1);
});

it("says a release three times within 100 ms, past whatever waits", () => {
  pump.begin(7, 20);
  sent = [];
  pump.insist();
  expect(sent.filter((drive) => drive.urgent)).toHaveLength(1);
  vi.advanceTimersByTime(100);
  expect(sent.filter((drive) => drive.urgent)).toHaveLength(3);
});
