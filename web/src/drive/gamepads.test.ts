// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { pad, plugIn, takeAwayGamepads } from "../testing/gamepads";
import { DRIVE_DEFAULTS } from "./drivePreferences";
import type { GamepadInputOptions } from "./gamepad";
import { Gamepads } from "./gamepads";
import { InputState } from "./inputState";

const SETTINGS = DRIVE_DEFAULTS.gamepad;
const tell = vi.fn();
let aborting: AbortController;

beforeEach(() => {
  vi.useFakeTimers();
  tell.mockClear();
  aborting = new AbortController();
});

afterEach(() => {
  aborting.abort();
  vi.clearAllTimers();
  vi.doUnmock("./gamepad");
  takeAwayGamepads();
});

function listening(): Gamepads {
  const movesSideways = () => false;
  const input = new InputState({ changed() {}, deflected() {}, movesSideways });
  const options: Partial<GamepadInputOptions> = {
    input,
    movesSideways,
    changed() {},
    tell,
    controls: () => [],
  };
  const pads = new Gamepads(window, {
    ...options,
    settings: () => SETTINGS,
  } as GamepadInputOptions);
  pads.listen(aborting.signal);
  return pads;
}

it("loads nothing before there is a gamepad, and it once for several", async () => {
  const pads = listening();
  await vi.dynamicImportSettled();
  expect(pads.input).toBeNull();
  plugIn([pad({ buttons: [] })]);
  await vi.dynamicImportSettled();
  const first = pads.input;
  expect(first).not.toBeNull();
  expect(tell).toHaveBeenCalledExactlyOnceWith("found_by_menu");
  plugIn([pad({ buttons: [] })]);
  await vi.dynamicImportSettled();
  expect(pads.input).toBe(first);
});

it("finds a gamepad that was there before, and none once the page is over", async () => {
  plugIn([pad({ buttons: [] })]);
  const pads = listening();
  await vi.dynamicImportSettled();
  expect(pads.input).not.toBeNull();
  const another = listening();
  aborting.abort();
  await vi.dynamicImportSettled();
  expect(another.input).toBeNull();
});

it("says so if it cannot be loaded, and tries again with the next gamepad", async () => {
  vi.doMock("./gamepad", () => {
    throw new TypeError("Failed to fetch");
  });
  vi.resetModules();
  const pads = listening();
  plugIn([pad()]);
  await vi.dynamicImportSettled();
  expect(tell).toHaveBeenCalledExactlyOnceWith("not_loaded");
  vi.doUnmock("./gamepad");
  plugIn([pad({ buttons: [] })]);
  await vi.dynamicImportSettled();
  expect(pads.input).not.toBeNull();
});
