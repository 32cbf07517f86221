/** Gamepads as the browser would list them, for tests. */

import { vi } from "vitest";

export interface FakePad {
  index: number;
  id: string;
  connected: boolean;
  mapping: GamepadMappingType;
  axes: number[];
  buttons: { pressed: boolean; touched: boolean; value: number }[];
}

/** A pad that nobody touches: four axes and 17 buttons. */
export function pad(more: Partial<FakePad> = {}): FakePad {
  return {
    index: 0,
    id: "Xbox",
    connected: true,
    mapping: "standard",
    axes: [0, 0, 0, 0],
    buttons: Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 })),
    ...more,
  };
}

export function push(on: FakePad, at: number, value = 1): void {
  on.buttons[at] = { pressed: value > 0, touched: value > 0, value };
}

/** Plugs these in; the list may be changed afterwards. */
export function plugIn(pads: (FakePad | null)[]): void {
  Object.defineProperty(navigator, "getGamepads", { value: () => pads, configurable: true });
  window.dispatchEvent(new Event("gamepadconnected"));
}

/** Lets the page load what reads gamepads, as it does once there was one. */
export async function loadGamepads(): Promise<void> {
  window.dispatchEvent(new Event("gamepadconnected"));
  await vi.dynamicImportSettled();
}

export function takeAwayGamepads(): void {
  Reflect.deleteProperty(navigator, "getGamepads");
}

/** Advances the fake timers by `count` readings of the gamepads, at the slower rate. */
export function readings(count: number): void {
  vi.advanceTimersByTime(50 * count);
}
