import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { numbers } from "../testing/random";
import { codeOf } from "./codeOf";
import { KeysDown, UNHEARD_MS } from "./keysDown";

let down: KeysDown;

beforeEach(() => {
  vi.useFakeTimers();
  down = new KeysDown(() => {});
});

afterEach(() => {
  down.clear();
});

const event = (code: string, key: string, more = {}) => ({
  code,
  key,
  repeat: false,
  metaKey: false,
  ...more,
});

it("holds nothing once each pressed key is released, whatever its events omit", () => {
  // The codes, and what an AZERTY keyboard has there.
  const keys = ["KeyW z", "KeyA q", "KeyQ a", "ArrowUp ArrowUp", "Numpad8 ArrowUp", "Digit1 1"];
  const between = numbers(5);
  const whole = (most: number) => Math.floor(between(0, most));
  for (let run = 0; run < 2000; run++) {
    const pressed = new Set<string>();
    const told = (key: string) => {
      const [code = "", name = ""] = key.split(" ");
      return event(whole(2) ? code : "", whole(2) ? name : "");
    };
    const lift = (key: string) => {
      pressed.delete(key);
      down.lift(told(key));
    };
    for (let step = 0; step < 12; step++) {
      const key = keys[whole(keys.length)] ?? "";
      if (pressed.has(key)) lift(key);
      else {
        pressed.add(key);
        down.press(told(key));
      }
    }
    for (const key of [...pressed]) lift(key);
    expect(down.names).toEqual([]);
  }
});

it("releases a key without a code that neither repeats nor comes up", () => {
  down.press(event("", "ArrowUp"));
  vi.advanceTimersByTime(UNHEARD_MS - 1);
  expect(down.press(event("", "ArrowUp", { repeat: true }))).toBe(false);
  vi.advanceTimersByTime(UNHEARD_MS - 1);
  expect(down.names).toEqual(["ArrowUp"]);
  vi.advanceTimersByTime(1);
  expect(down.names).toEqual([]);
  expect(down.press(event("", "ArrowUp"))).toBe(true);
});

it("waits for no release of a key pressed with Meta, which macOS does not report", () => {
  expect(down.press(event("KeyW", "w", { metaKey: true }))).toBe(true);
  expect(down.names).toEqual([]);
  expect(down.press(event("KeyW", "w"))).toBe(true);
  expect(down.names).toEqual(["KeyW"]);
});

it("releases only the lifted one of two keys without a code", () => {
  down.press(event("", "ArrowUp"));
  down.press(event("", "ArrowLeft"));
  down.lift(event("", "ArrowUp"));
  expect(down.names).toEqual(["ArrowLeft"]);
});

it.each([
  ["Space", " "],
  ["", " "],
  ["", "Spacebar"],
  ["KeyB", " "],
  ["Space", "Process"],
])("takes code %j and key %j for Space", (code, key) => {
  expect(codeOf({ code, key })).toBe("Space");
});

it.each([
  ["Numpad8", "ArrowUp", {}, "ArrowUp"],
  ["Numpad8", "8", {}, "Numpad8"],
  ["KeyW", "ц", {}, "KeyW"],
  ["KeyW", "Process", {}, ""],
  ["KeyW", "w", { keyCode: 229 }, ""],
  ["KeyW", "w", { isComposing: true }, ""],
  ["BracketLeft", "Dead", {}, "BracketLeft"],
  ["", "Dead", {}, ""],
])("takes code %j and key %j, %j for %j", (code, key, more, is) => {
  expect(codeOf({ code, key, ...more })).toBe(is);
});

it("releases both if a release without a code may belong to either", () => {
  down.press(event("Numpad8", "ArrowUp"));
  down.press(event("", "ArrowUp"));
  down.lift(event("", "ArrowUp"));
  expect(down.names).toEqual([]);
});
