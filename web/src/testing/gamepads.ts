/** Gamepads that the browser would name, for tests. */

import { vi } from "vitest";

export interface FakePad {
  index: number;
  id: string;
  connected: boolean;
  mapping: GamepadMappingType;
  axes: number[];
  buttons: { pressed: boolean; touched: boolean; value: number }[];
}

/** A pad as it is when nobody touches it: four axes and 17 buttons. */
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

/** Plugs these in; the list can be changed while it is. */
export function plugIn(pads: (FakePad | null)[]): void {
  Object.defineProperty(navigator, "getGamepads", { value: () => pads, configurable: true });
  window.dispatchEvent(new Event("gamepadconnected"));
}

export function takeAwayGamepads(): void {
  Reflect.deleteProperty(navigator, "getGamepads");
}

/** Waits until gamepads were read so often, at the slower pace; timers are fake. */
export function readings(count: number): void {
  vi.advanceTimersByTime(50 * count);
}
