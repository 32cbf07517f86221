import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { listenLetGo } from "../drive/letGo";
import { SessionWindow } from "./sessionWindow";

let session: EventTarget & { visibilityState: XRVisibilityState };
let seen: SessionWindow;

beforeEach(() => {
  vi.useFakeTimers();
  session = Object.assign(new EventTarget(), { visibilityState: "visible" as XRVisibilityState });
  seen = new SessionWindow(session, () => ({ id: "headset" }));
  seen.drawn();
});
afterEach(() => vi.useRealTimers());

function become(state: XRVisibilityState): void {
  session.visibilityState = state;
  session.dispatchEvent(new Event("visibilitychange"));
}

describe("lets go as a hidden tab does", () => {
  const letGo = vi.fn();
  beforeEach(() => {
    letGo.mockClear();
    const { signal } = new AbortController();
    listenLetGo(seen.asWindow, { letGo, lift: () => false, signal });
  });

  it.each(["hidden", "visible-blurred"] as const)("when the session is %s", (state) => {
    become(state);
    expect(letGo).toHaveBeenCalledTimes(1);
    expect(seen.document.hasFocus()).toBe(false);
    become("visible");
    expect(letGo).toHaveBeenCalledTimes(1);
    expect(seen.document.hasFocus()).toBe(true);
  });

  it("when the session ends", () => {
    session.dispatchEvent(new Event("end"));
    expect(letGo).toHaveBeenCalledTimes(1);
    expect(seen.document.hidden).toBe(true);
  });
});

it("is hidden while nothing is drawn", () => {
  vi.advanceTimersByTime(150);
  expect(seen.document.hidden).toBe(false);
  vi.advanceTimersByTime(1);
  expect(seen.document.hidden).toBe(true);
  seen.drawn();
  expect(seen.document.hidden).toBe(false);
});

it("is hidden before the first frame", () => {
  expect(new SessionWindow(session, () => ({})).document.hidden).toBe(true);
});

it("has one gamepad, which stays", () => {
  expect(seen.navigator.getGamepads()).toEqual([{ id: "headset", index: 0, connected: true }]);
});
