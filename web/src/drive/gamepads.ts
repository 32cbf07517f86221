/** Loads what reads gamepads (`gamepad.ts`) once there is one; most people have none. */

import type { GamepadInput, GamepadInputOptions } from "./gamepad";
import type { PadLayout, PadPart } from "./padReading";

/** The gamepads that the browser lists, and the one that the user has chosen to drive with. */
export interface PadState {
  found: readonly { index: number; id: string; layout: PadLayout }[];
  chosen: number | null;
  /** Whether the chosen one moves the robot: only once everything on it has been released. */
  isReady: boolean;
  /** What on it must still be released. */
  held: readonly PadPart[];
  /** Axes with a stored rest that must be moved and released once before that rest is trusted. */
  unmoved: readonly PadPart[];
}

export const NO_PADS: PadState = {
  found: [],
  chosen: null,
  isReady: false,
  held: [],
  unmoved: [],
};

/**
 * `found_by_menu`: none of the pads has a usable Start button; `not_loaded`: what reads them could
 * not be loaded.
 */
export type PadNews = "found" | "found_by_menu" | "lost" | "frozen" | "not_loaded";

export class Gamepads {
  /** Null before there is a gamepad. */
  input: GamepadInput | null = null;

  constructor(
    private readonly window: Window,
    private readonly options: GamepadInputOptions,
  ) {}

  listen(signal: AbortSignal): void {
    const load = async () => {
      const loaded = await import("./gamepad").catch(() => null);
      if (!loaded) this.options.tell("not_loaded");
      if (!loaded || this.input || signal.aborted) return;
      this.input = new loaded.GamepadInput(this.window, this.options);
      this.input.listen(signal);
    };
    this.window.addEventListener("gamepadconnected", load, { signal });
    if (this.window.navigator.getGamepads?.().some(Boolean)) void load();
  }
}
