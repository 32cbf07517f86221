// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { listenTalk } from "./listenTalk";

const talk = { press: vi.fn(), release: vi.fn(() => true), letGo: vi.fn() };
let ending: AbortController;

beforeEach(() => {
  vi.clearAllMocks();
  document.body.innerHTML = "<input type=text><input type=range><p></p>";
  ending = new AbortController();
  listenTalk(window, talk, (code) => code === "KeyT", ending.signal);
});

afterEach(() => ending.abort());

function key(type: string, code = "KeyT", on = "p", more: KeyboardEventInit = {}): void {
  const target = document.querySelector(on);
  target?.dispatchEvent(new KeyboardEvent(type, { code, bubbles: true, ...more }));
}

it("speaks while T is held, without repeating", () => {
  key("keydown");
  key("keydown", "KeyT", "p", { repeat: true });
  expect(talk.press).toHaveBeenCalledExactlyOnceWith("key KeyT");
  key("keyup");
  expect(talk.release).toHaveBeenCalledExactlyOnceWith("key KeyT");
});

it.each([
  ["another key", "KeyW", "p", {}],
  ["a shortcut", "KeyT", "p", { ctrlKey: true }],
  ["a name that is typed", "KeyT", "[type=text]", {}],
])("%s is not for the voice", (_, code, on, more) => {
  key("keydown", code, on, more);
  expect(talk.press).not.toHaveBeenCalled();
});

it("a focused slider does not prevent speaking", () => {
  key("keydown", "KeyT", "[type=range]");
  expect(talk.press).toHaveBeenCalledOnce();
});

it.each(["blur", "pagehide"])("falls silent on %s, after which no release would come", (type) => {
  window.dispatchEvent(new Event(type));
  expect(talk.letGo).toHaveBeenCalled();
});

it("a finger lifted anywhere releases", () => {
  window.dispatchEvent(new PointerEvent("pointerup", { pointerId: 3 }));
  expect(talk.release).toHaveBeenCalledWith("pointer 3");
});
