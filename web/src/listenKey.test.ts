// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { listenKey } from "./listenKey";

const act = vi.fn();
let aborting: AbortController;

beforeEach(() => {
  act.mockClear();
  aborting = new AbortController();
  listenKey(window, act, (code) => code === "KeyM", aborting.signal);
});

afterEach(() => aborting.abort());

it.each([
  ["by the place", { code: "KeyM", key: "ь" }, 1],
  ["by the name where no place is told", { code: "", key: "M" }, 1],
  ["not by the name where the place is another key's", { code: "KeyA", key: "m" }, 0],
  ["not by what an input method keeps", { code: "KeyM", key: "Process" }, 0],
  ["not by a repeat", { code: "", key: "m", repeat: true }, 0],
  ["not with Meta", { code: "KeyM", key: "m", metaKey: true }, 0],
])("acts %s", (_, told, times) => {
  window.dispatchEvent(new KeyboardEvent("keydown", told));
  expect(act).toHaveBeenCalledTimes(times);
});
