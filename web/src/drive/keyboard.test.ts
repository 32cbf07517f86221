// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { DIRECTIONS, fingerHolder, InputState } from "./inputState";
import { listenKeyboard } from "./keyboard";
import { DEFAULT_KEYS, type KeyMap, keysInForce } from "./keyMap";
import { listenLetGo } from "./letGo";

const stop = vi.fn();
const anyKey = vi.fn();
let aborting: AbortController;
let input: InputState;
let driving: boolean;
let keys: KeyMap;
let isPlanar: boolean;

beforeEach(() => {
  stop.mockClear();
  anyKey.mockClear();
  keys = DEFAULT_KEYS;
  aborting = new AbortController();
  driving = true;
  isPlanar = false;
  input = new InputState({
    changed: () => {},
    deflected: () => {},
    movesSideways: () => isPlanar,
  });
  input.enable();
  const letGo = () => input.releaseAll();
  const { signal } = aborting;
  listenKeyboard(window, {
    keys: () => keysInForce(keys, isPlanar),
    isDriving: () => driving,
    isFor: (action) => action !== "talk",
    press(holder, action) {
      if (action === "stop") stop();
      else input.press(holder, DIRECTIONS.find((one) => one === action) ?? null);
    },
    release: (holder) => input.release(holder),
    anyKey,
    letGo,
    signal,
  });
  const lift = (pointerId: number) => input.release(fingerHolder(pointerId));
  listenLetGo(window, { letGo, lift, signal });
});

afterEach(() => {
  aborting.abort();
  document.body.replaceChildren();
});

function key(type: "keydown" | "keyup", code: string, more: KeyboardEventInit = {}): KeyboardEvent {
  const event = new KeyboardEvent(type, { code, bubbles: true, cancelable: true, ...more });
  (document.activeElement ?? document.body).dispatchEvent(event);
  return event;
}

function focused(html: string): void {
  document.body.innerHTML = html;
  (document.body.firstElementChild as HTMLElement).focus();
}

it.each([
  ["ArrowUp", { linear: 1, angular: 0 }],
  ["ArrowDown", { linear: -1, angular: 0 }],
  ["ArrowLeft", { linear: 0, angular: 1 }],
  ["ArrowRight", { linear: 0, angular: -1 }],
  ["KeyW", { linear: 1, angular: 0 }],
  ["KeyS", { linear: -1, angular: 0 }],
  ["KeyA", { linear: 0, angular: 1 }],
  ["KeyD", { linear: 0, angular: -1 }],
])("%s moves while it is held", (code, motion) => {
  expect(key("keydown", code).defaultPrevented).toBe(true);
  expect(input.motion).toEqual(motion);
  key("keyup", code);
  expect(input.motion).toEqual({ linear: 0, angular: 0 });
});

describe("a robot that moves sideways", () => {
  beforeEach(() => {
    isPlanar = true;
  });

  it.each([
    ["KeyQ", {}, 1],
    ["KeyE", {}, -1],
    ["ArrowLeft", { shiftKey: true }, 1],
    ["ArrowRight", { shiftKey: true }, -1],
  ])(
    "is moved sideways by %s, until the key is released with or without Shift",
    (code, how, to) => {
      expect(key("keydown", code, how).defaultPrevented).toBe(true);
      expect(input.motion).toEqual({ linear: 0, angular: 0, lateral: to });
      key("keydown", code, { repeat: true });
      expect(input.motion).toEqual({ linear: 0, angular: 0, lateral: to });
      key("keyup", code);
      expect(input.isHolding).toBe(false);
    },
  );

  it("is stopped by Space while it moves so, whatever has the focus, and with Shift", () => {
    keys = { ...DEFAULT_KEYS, lateral_left: ["Shift+KeyP"] };
    focused("<button>Fast</button>");
    key("keydown", "KeyP", { shiftKey: true });
    expect(input.motion.lateral).toBe(1);
    key("keydown", "Space", { shiftKey: true });
    expect(stop).toHaveBeenCalledOnce();
  });
});

it.each(["KeyQ", "KeyE"])("leaves %s alone on a robot that cannot move sideways", (code) => {
  expect(key("keydown", code).defaultPrevented).toBe(false);
  expect(input.isHolding).toBe(false);
});

it("stops by Space while a direction is held, even if a button has the focus", () => {
  focused("<button>Fast</button>");
  key("keydown", "Space");
  key("keyup", "Space");
  expect(stop).not.toHaveBeenCalled();
  key("keydown", "ArrowUp");
  expect(key("keydown", "Space").defaultPrevented).toBe(true);
  expect(stop).toHaveBeenCalledOnce();
  expect(key("keyup", "Space").defaultPrevented).toBe(true);
});

it("releases only the lifted one of two keys for a direction", () => {
  key("keydown", "ArrowUp");
  key("keydown", "KeyW");
  key("keyup", "KeyW");
  expect(input.motion.linear).toBe(1);
});

it("does not count a repeat as a new press", () => {
  key("keydown", "ArrowUp", { repeat: true });
  expect(input.motion.linear).toBe(0);
});

it("needs a new press of a key that was held when the turn began", () => {
  driving = false;
  input.disable();
  key("keydown", "ArrowUp");
  driving = true;
  input.enable();
  key("keydown", "ArrowUp");
  expect(input.motion.linear).toBe(0);
  key("keyup", "ArrowUp");
  key("keydown", "ArrowUp");
  expect(input.motion.linear).toBe(1);
});

it.each(["ctrlKey", "metaKey", "altKey"])("releases everything when %s is down", (modifier) => {
  key("keydown", "ArrowUp");
  const event = key("keydown", "KeyW", { [modifier]: true });
  expect(event.defaultPrevented).toBe(false);
  expect(input.motion.linear).toBe(0);
});

it("leaves letters and arrows to a text field, but still handles the release", () => {
  key("keydown", "ArrowUp");
  focused("<input type='text'>");
  key("keydown", "KeyA");
  expect(input.motion).toEqual({ linear: 1, angular: 0 });
  key("keyup", "ArrowUp");
  expect(input.motion.linear).toBe(0);
});

it("handles no keys while this page does not drive", () => {
  driving = false;
  expect(key("keydown", "ArrowUp").defaultPrevented).toBe(false);
  expect(key("keydown", "Space").defaultPrevented).toBe(false);
  expect(stop).not.toHaveBeenCalled();
});

it("stops by Space, unless Space operates the focused element", () => {
  key("keydown", "Space");
  expect(stop).toHaveBeenCalledOnce();
  key("keydown", "Space", { repeat: true });
  expect(stop).toHaveBeenCalledOnce();
  focused("<button>Sound</button>");
  key("keydown", "Space");
  expect(stop).toHaveBeenCalledOnce();
});

it("handles a key pressed while nothing has the focus", () => {
  window.dispatchEvent(new KeyboardEvent("keydown", { code: "ArrowUp" }));
  expect(input.motion.linear).toBe(1);
  window.dispatchEvent(new KeyboardEvent("keydown", { code: "Space" }));
  expect(stop).toHaveBeenCalledOnce();
});

it.each(["blur", "pagehide", "beforeunload", "contextmenu"])("releases on %s", (type) => {
  key("keydown", "ArrowUp");
  window.dispatchEvent(new Event(type));
  expect(input.isHolding).toBe(false);
});

it("releases everything when the page is frozen", () => {
  key("keydown", "ArrowUp");
  document.dispatchEvent(new Event("freeze"));
  expect(input.isHolding).toBe(false);
});

it("releases what a finger holds wherever it is lifted, and only that", () => {
  input.press(fingerHolder(3), "forward");
  input.press(fingerHolder(4), "left");
  window.dispatchEvent(new PointerEvent("pointerup", { pointerId: 3 }));
  expect(input.motion).toEqual({ linear: 0, angular: 1 });
});

it("releases everything when the system cancels a touch that held something", () => {
  key("keydown", "ArrowUp");
  window.dispatchEvent(new PointerEvent("pointercancel", { pointerId: 3 }));
  expect(input.motion.linear).toBe(1);
  input.press(fingerHolder(3), "left");
  window.dispatchEvent(new PointerEvent("pointercancel", { pointerId: 3 }));
  expect(input.isHolding).toBe(false);
});

it("releases everything when the page is hidden", () => {
  key("keydown", "ArrowUp");
  vi.spyOn(document, "hidden", "get").mockReturnValue(true);
  document.dispatchEvent(new Event("visibilitychange"));
  expect(input.motion.linear).toBe(0);
});

it("stays released when the page is shown again", () => {
  key("keydown", "ArrowUp");
  document.dispatchEvent(new Event("visibilitychange"));
  expect(input.motion.linear).toBe(1);
});

it("drives again by a new press after the window was away", () => {
  key("keydown", "ArrowUp");
  window.dispatchEvent(new Event("blur"));
  key("keydown", "ArrowUp");
  expect(input.motion.linear).toBe(1);
});

it("drives by this user's keys only", () => {
  keys = { ...DEFAULT_KEYS, forward: ["KeyE"] };
  key("keydown", "ArrowUp");
  expect(input.isHolding).toBe(false);
  key("keydown", "KeyE");
  expect(input.motion.linear).toBe(1);
});

it("ignores a key that has been handled elsewhere", () => {
  expect(key("keydown", "KeyT").defaultPrevented).toBe(false);
  expect(key("keydown", "KeyZ").defaultPrevented).toBe(false);
  expect(input.isHolding).toBe(false);
});

it("leaves Enter to the focused element", () => {
  focused("<button>Sound</button>");
  expect(key("keydown", "Enter").defaultPrevented).toBe(false);
  document.body.replaceChildren();
  expect(key("keydown", "Enter").defaultPrevented).toBe(true);
});

it("reports each key once, but none that a control has handled", () => {
  key("keydown", "KeyZ");
  key("keydown", "KeyZ", { repeat: true });
  expect(anyKey).toHaveBeenCalledOnce();
  focused("<button>Forward</button>");
  document.activeElement?.addEventListener("keydown", (event) => event.preventDefault());
  key("keydown", "ArrowUp");
  expect(anyKey).toHaveBeenCalledOnce();
  expect(input.isHolding).toBe(false);
});

it("identifies a key without a code by its name: it drives, and Space stops", () => {
  key("keydown", "", { key: "ArrowUp" });
  expect(input.motion).toMatchObject({ linear: 1 });
  key("keydown", "", { key: " " });
  expect(stop).toHaveBeenCalledOnce();
  key("keydown", "", { key: "W" });
  key("keyup", "", { key: "ArrowUp" });
  expect(input.motion).toMatchObject({ linear: 1 });
  key("keyup", "", { key: "w" });
  expect(input.motion).toMatchObject({ linear: 0 });
});

it.each(["Process", "Dead", "Unidentified", "", "é"])("ignores %j", (name) => {
  key("keydown", "", { key: name });
  expect(input.motion).toMatchObject({ linear: 0, angular: 0 });
  expect(stop).not.toHaveBeenCalled();
});

it("stops by a second Space although the first was never released", () => {
  key("keydown", "Space");
  key("keydown", "Space");
  expect(stop).toHaveBeenCalledTimes(2);
});
