import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { loadPreferences } from "./preferences";
import { createState } from "./state";
import { hello, room } from "./testing/messages";
import { keepAwake, needsScreen } from "./wakeLock";
import { says } from "./words/said";

class Lock extends EventTarget {
  released = false;
  release = async () => {
    this.released = true;
    this.dispatchEvent(new Event("release"));
  };
}

class Page extends EventTarget {
  visibilityState: DocumentVisibilityState = "visible";
  show(state: DocumentVisibilityState): void {
    this.visibilityState = state;
    this.dispatchEvent(new Event("visibilitychange"));
  }
}

let locks: Lock[];
let page: Page;
let request: ReturnType<typeof vi.fn<() => Promise<WakeLockSentinel>>>;
let end = () => {};
const isNeeded = signal(false);
const settled = () => new Promise((done) => setTimeout(done));
const held = () => locks.filter((one) => !one.released).length;

beforeEach(() => {
  locks = [];
  page = new Page();
  isNeeded.value = false;
  request = vi.fn(async () => {
    const lock = new Lock();
    locks.push(lock);
    return lock as unknown as WakeLockSentinel;
  });
});

afterEach(() => end());

function begin(): void {
  end = keepAwake(isNeeded, { document: page as unknown as Document, wakeLock: { request } });
}

it("holds the lock only while it is needed", async () => {
  begin();
  await settled();
  expect(request).not.toHaveBeenCalled();
  isNeeded.value = true;
  await settled();
  expect(held()).toBe(1);
  isNeeded.value = false;
  await settled();
  expect(held()).toBe(0);
});

it("requests it again once the page is shown again", async () => {
  begin();
  isNeeded.value = true;
  await settled();
  page.show("hidden");
  await settled();
  expect(held()).toBe(0);
  page.show("visible");
  await settled();
  expect([held(), locks.length]).toEqual([1, 2]);
});

it("requests it again after the browser released it, when the page is next shown", async () => {
  begin();
  isNeeded.value = true;
  await settled();
  await locks[0]?.release();
  page.show("visible");
  await settled();
  expect(held()).toBe(1);
});

it("is silent about a refusal, and requests it the next time", async () => {
  request.mockRejectedValueOnce(new DOMException("low battery", "NotAllowedError"));
  begin();
  isNeeded.value = true;
  await settled();
  expect(held()).toBe(0);
  page.show("visible");
  await settled();
  expect(held()).toBe(1);
});

it("requests it the next time if the browser has not answered for 4 s", async () => {
  vi.useFakeTimers();
  request.mockReturnValueOnce(new Promise(() => {}));
  begin();
  isNeeded.value = true;
  await vi.advanceTimersByTimeAsync(4000);
  page.show("visible");
  await vi.advanceTimersByTimeAsync(0);
  expect(held()).toBe(1);
});

it("releases a lock that arrives too late", async () => {
  begin();
  isNeeded.value = true;
  isNeeded.value = false;
  await settled();
  expect(held()).toBe(0);
});

it("releases at the end, and works without the API", async () => {
  begin();
  isNeeded.value = true;
  await settled();
  end();
  await settled();
  expect(held()).toBe(0);
  keepAwake(isNeeded, { document: page as unknown as Document, wakeLock: undefined })();
});

it("is needed to drive, wait or watch, not to listen only", () => {
  const state = createState(loadPreferences(null));
  const needs = needsScreen(state);
  state.hello.value = hello({ viewer: 1 });
  state.room.value = room({ watching: [1] });
  expect(needs.value).toBe(false);
  state.link.value = { is: "connected" };
  expect(needs.value).toBe(true);
  state.preferences.value = { ...state.preferences.peek(), picture: false };
  expect(needs.value).toBe(false);
  state.room.value = room({ waiting: [1] });
  expect(needs.value).toBe(true);
  state.room.value = room({ operator: 1 });
  expect(needs.value).toBe(true);
  state.ended.value = { type: "ended", text: says("Closed."), openings: [] };
  expect(needs.value).toBe(false);
});
