import { expect, it } from "vitest";
import { ServerClock } from "../serverClock";
import { Heartbeat } from "./heartbeat";

function pong(id: number, sentMs: number, serverMs: number, beat = "x7-_2A") {
  return { type: "pong", id, sent_page_ms: sentMs, server_ms: serverMs, beat } as const;
}

it("numbers its pings and returns the newest pong with the time it was held", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  const first = heartbeat.nextPing(100);
  expect(first).toMatchObject({ id: 1, sent_page_ms: 100, pong_id: null, pong_held_ms: null });
  heartbeat.nextPing(150);
  heartbeat.handlePong(pong(2, 150, 9155), 160);
  heartbeat.handlePong(pong(1, 100, 9105), 165);
  expect(heartbeat.nextPing(200)).toMatchObject({ id: 3, pong_id: 2, pong_held_ms: 40 });
});

it("keeps the newest beat, from a pong or between two", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  expect(heartbeat.newestBeat).toBeNull();
  heartbeat.nextPing(100);
  heartbeat.handlePong(pong(1, 100, 9105, "first1"), 110);
  expect(heartbeat.newestBeat).toBe("first1");
  heartbeat.storeBeat("second");
  expect(heartbeat.newestBeat).toBe("second");
});

it("aligns the clock by every pong", () => {
  const clock = new ServerClock();
  const heartbeat = new Heartbeat(clock);
  heartbeat.nextPing(100);
  heartbeat.handlePong(pong(1, 100, 9105), 110);
  expect(clock.toServerMs(110)).toBe(9110);
});

it("waits longer while three pings are unanswered, since more would queue behind them", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  const pausesMs = [1, 2, 3].map(() => {
    heartbeat.nextPing(100);
    return heartbeat.pauseMs(100, false);
  });
  expect(pausesMs).toEqual([50, 50, 200]);
  heartbeat.handlePong(pong(1, 100, 0), 400);
  expect(heartbeat.pauseMs(400, false)).toBe(50);
});

it("is eager in the first second only", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  heartbeat.nextPing(5000);
  expect(heartbeat.pauseMs(5000, false)).toBe(50);
  expect(heartbeat.pauseMs(5999, true)).toBe(50);
  expect(heartbeat.pauseMs(6000, true)).toBe(200);
  expect(heartbeat.pauseMs(6000, false)).toBe(1000);
});

it("is eager only until a few pongs have arrived", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  for (let id = 1; id <= 6; id++) {
    heartbeat.nextPing(100);
    expect(heartbeat.pauseMs(110, false)).toBe(50);
    heartbeat.handlePong(pong(id, 100, 0), 110);
  }
  expect(heartbeat.pauseMs(110, false)).toBe(1000);
});

it.each([
  [false, 3000],
  [true, 2000],
])("calls so much time of unanswered pings silence, driving: %s", (isKeen, ms) => {
  const heartbeat = new Heartbeat(new ServerClock());
  expect(heartbeat.isSilent(1e6, isKeen)).toBe(false);
  for (let atMs = 1000; atMs < 1000 + ms; atMs += 1000) heartbeat.nextPing(atMs);
  expect(heartbeat.isSilent(999 + ms, isKeen)).toBe(false);
  expect(heartbeat.isSilent(1000 + ms, isKeen)).toBe(true);
  heartbeat.handlePong(pong(2, 2000, 0), 1100 + ms);
  expect(heartbeat.isSilent(60_000, isKeen)).toBe(false);
});

it("does not count a hang of the page as silence", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  heartbeat.nextPing(1000);
  expect(heartbeat.isSilent(61_000, true)).toBe(false);
  heartbeat.nextPing(61_000);
  expect(heartbeat.isSilent(61_400, true)).toBe(false);
  expect(heartbeat.isSilent(61_500, true)).toBe(true);
});

it("knows how long it has waited for an answer", () => {
  const heartbeat = new Heartbeat(new ServerClock());
  expect(heartbeat.unansweredMs(500)).toBe(0);
  heartbeat.nextPing(1000);
  heartbeat.nextPing(1200);
  expect(heartbeat.unansweredMs(1300)).toBe(300);
  heartbeat.handlePong(pong(1, 1000, 0), 1310);
  expect(heartbeat.unansweredMs(1400)).toBe(0);
});
