import { expect, it } from "vitest";
import { missedCall } from "./call";
import { room } from "./testing/messages";

const call = { viewer: 1, until_server_ms: 10_000 };
const called = { ...room({ operator: 2, waiting: [1] }), call };

it("is missed at its deadline, and the place is kept once", () => {
  const after = room({ operator: 3, waiting: [1] });
  expect(missedCall(called, after, 1, 10_100, null)).toBe("kept");
  expect(missedCall(called, room({ operator: 3, watching: [1] }), 1, 10_100, null)).toBe("lost");
});

it("is not missed when it ends earlier, by an answer or otherwise", () => {
  const after = room({ operator: 2, waiting: [1] });
  expect(missedCall(called, after, 1, 5000, null)).toBeNull();
});

it("of another viewer does not matter", () => {
  const other = { ...called, call: { ...call, viewer: 3 } };
  expect(missedCall(other, room({ operator: 2, waiting: [1] }), 1, 20_000, null)).toBeNull();
});

it("that was missed once is shown until the next call, the turn, or leaving the queue", () => {
  const waits = room({ operator: 3, waiting: [1] });
  expect(missedCall(waits, waits, 1, 20_000, "kept")).toBe("kept");
  expect(missedCall(waits, called, 1, 20_000, "kept")).toBeNull();
  expect(missedCall(waits, room({ operator: 1 }), 1, 20_000, "kept")).toBeNull();
  expect(missedCall(waits, room({ operator: 3, watching: [1] }), 1, 20_000, "kept")).toBeNull();
});

it("that cost the place is shown until the viewer queues again", () => {
  const watches = room({ operator: 3, watching: [1] });
  expect(missedCall(watches, watches, 1, 20_000, "lost")).toBe("lost");
});
