/** When the chosen gamepad drives; what it says: `padReading.ts`; in doubt: `padRest.ts`. */

import { DIRECTIONS, type Direction, type InputState } from "./inputState";
import {
  layoutOf,
  type PadLayout,
  type PadPart,
  type PadReading,
  type PadSettings,
  readPad,
} from "./padReading";
import { PadRest } from "./padRest";
import type { Ways } from "./ways";

/** The gamepads that the browser names, and the one that the user has chosen to drive with. */
export interface PadState {
  found: readonly { index: number; id: string; layout: PadLayout }[];
  chosen: number | null;
  /** Whether the chosen one moves the robot; it does once all on it was let go. */
  isReady: boolean;
  /** What of it must still be let go of. */
  held: readonly PadPart[];
  /** What must be moved away from its own rest and let go, before that is believed. */
  unmoved: readonly PadPart[];
}

export const NO_PADS: PadState = {
  found: [],
  chosen: null,
  isReady: false,
  held: [],
  unmoved: [],
};

/** `found_by_menu`: none of them has a Start that is listened to. */
export type PadNews = "found" | "found_by_menu" | "lost" | "frozen";

export interface GamepadInputOptions {
  input: InputState;
  ways: Ways;
  settings: () => PadSettings;
  isDriving: () => boolean;
  stop: () => void;
  toggleSpeed: () => void;
  changed: (state: PadState) => void;
  /** Gamepads were found, of which nothing is used; or the one in use was lost, or says nothing new. */
  tell: (what: PadNews) => void;
}

const STICK = "gamepad stick";
const crossHolder = (direction: Direction) => `gamepad ${direction}`;
/** For so long a new gamepad is listened to for its Start. */
const OFFERED_MS = 20_000;
/** While this page may drive: browsers draw rarely compared with what a push may wait. */
const DRIVING_MS = 8;
/** Before that, to see what is plugged in, pressed or let go. */
const LOOKING_MS = 50;

/**
 * Drives with a gamepad that the user has chosen. It is read by a timer, often while this page may
 * drive, while it is used or has just been found. At first, whenever all was released or it was set
 * otherwise, and in any doubt (`PadRest`), it moves nothing until everything on it was let go once.
 */
export class GamepadInput {
  #state = NO_PADS;
  #offeredUntilMs = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #rest = new PadRest();
  #settings: PadSettings | null = null;
  #last: PadReading | null = null;
  #isDeflected = false;
  #starts = new Set<number>();

  constructor(
    private readonly window: Window,
    private readonly options: GamepadInputOptions,
  ) {}

  listen(signal: AbortSignal): void {
    this.window.addEventListener("gamepadconnected", () => this.#offer(), { signal });
    this.window.addEventListener("gamepaddisconnected", () => this.#look(), { signal });
    signal.addEventListener("abort", () => this.use(null));
    if (this.#pads().length > 0) this.#offer();
  }

  /** Drives with this gamepad from now on, with none for null. */
  use(index: number | null): void {
    this.#disarm();
    this.#last = null;
    const isThere = this.#pads().some((pad) => pad.index === index);
    this.#offeredUntilMs = 0;
    this.#set({ chosen: isThere ? index : null });
    if (this.#state.chosen === null) return;
    this.#rest = new PadRest();
    this.#read();
  }

  /** Where the axes of the one in use rest, if all that hold it are let go; null unless they stood still. */
  restNow(): readonly number[] | null {
    if (!this.#last || !this.#rest.isStill(performance.now())) return null;
    const { axes, held } = this.#last;
    const rests: number[] = [0, 0, 0];
    for (const { at, value, rest } of axes) {
      const isHeld = held.some((part) => part.kind === "axis" && part.at === at);
      rests[at] = isHeld ? Math.max(-1, Math.min(1, value)) : rest;
    }
    return rests;
  }

  #pads(): Gamepad[] {
    const all = this.window.navigator.getGamepads?.() ?? [];
    return all.filter((pad) => pad?.connected === true) as Gamepad[];
  }

  #offer(): void {
    this.#look();
    if (this.#state.chosen !== null) return;
    const hasStart = this.#state.found.some(({ layout }) => layout === "standard");
    this.options.tell(hasStart ? "found" : "found_by_menu");
    this.#offeredUntilMs = performance.now() + OFFERED_MS;
    // What is pressed now was pressed to be found.
    this.#starts = new Set(this.#pads().map((pad) => pad.index));
    this.#read();
  }

  /** Sees which gamepads there are; loses the one in use if it is none of them any more. */
  #look(): Gamepad[] {
    const pads = this.#pads();
    const { found: before, chosen } = this.#state;
    const idOf = (all: readonly { index: number; id: string }[]) =>
      all.find((pad) => pad.index === chosen)?.id;
    const isLost = chosen !== null && idOf(pads) !== idOf(before);
    const isSame = (pad: Gamepad, at: number) =>
      pad.index === before[at]?.index && pad.id === before[at].id;
    if (pads.length !== before.length || !pads.every(isSame)) {
      this.#set({
        found: pads.map((pad) => ({ index: pad.index, id: pad.id, layout: layoutOf(pad) })),
      });
    }
    if (isLost) {
      this.use(null);
      this.options.tell("lost");
    }
    return pads;
  }

  #read(): void {
    clearTimeout(this.#timer);
    const pads = this.#look();
    const nowMs = performance.now();
    const isOffered = nowMs < this.#offeredUntilMs;
    if (isOffered) this.#listenToStarts(pads);
    const { chosen } = this.#state;
    const pad = pads.find((one) => one.index === chosen);
    if (pad) this.#follow(pad, nowMs);
    if (!pad && !isOffered) return;
    const afterMs = pad && this.options.input.isEnabled ? DRIVING_MS : LOOKING_MS;
    this.#timer = setTimeout(() => this.#read(), afterMs);
  }

  #listenToStarts(pads: readonly Gamepad[]): void {
    for (const pad of pads) {
      const isPressed = readPad(pad, this.options.settings()).start;
      if (!isPressed) this.#starts.delete(pad.index);
      else if (!this.#starts.has(pad.index)) {
        this.use(pad.index);
        return;
      }
    }
  }

  #follow(pad: Gamepad, nowMs: number): void {
    const { document } = this.window;
    const settings = this.options.settings();
    // What stood within the dead zone of before may be away from the rest of now.
    if (settings !== this.#settings) {
      this.#disarm();
      this.#rest = new PadRest();
    }
    this.#settings = settings;
    const now = readPad(pad, settings);
    const last = this.#last ?? now;
    this.#last = now;
    // A page that is not in front gets no keys either.
    const isInFront = !document.hidden && document.hasFocus();
    if (isInFront && this.options.isDriving() && now.stop && !last.stop) this.options.stop();
    // Where it is not, browsers say what was.
    const doubt = isInFront ? this.#rest.doubt(pad, now, nowMs) : null;
    if (doubt === "frozen" && this.#state.isReady) this.options.tell(doubt);
    if (doubt !== null) this.#disarm();
    if (!isInFront || !this.options.input.isEnabled) {
      this.#disarm();
    } else if (this.#state.isReady) {
      this.#drive(now, last);
    } else {
      this.#await(this.#rest.isLetGo(pad, now, nowMs), now.held);
    }
  }

  /** Is ready once nothing is held any more; says until then what is, and what is to be moved. */
  #await(isReady: boolean, held: readonly PadPart[]): void {
    const unmoved = this.#rest.unmoved.map((at) => ({ kind: "axis" as const, at }));
    const before = JSON.stringify([this.#state.held, this.#state.unmoved]);
    if (isReady || JSON.stringify([held, unmoved]) !== before) {
      this.#set({ isReady, held, unmoved });
    }
  }

  #drive(now: PadReading, last: PadReading): void {
    const { input, ways, toggleSpeed } = this.options;
    if (now.speed && !last.speed) toggleSpeed();
    for (const one of DIRECTIONS) {
      const [is, was] = [now.directions.has(one), last.directions.has(one)];
      if (is && !was) ways.press(crossHolder(one), one);
      if (was && !is) ways.release(crossHolder(one));
    }
    const isDeflected = now.motion.linear !== 0 || now.motion.angular !== 0;
    const wasDeflected = this.#isDeflected;
    this.#isDeflected = isDeflected;
    if (!isDeflected) input.release(STICK);
    else if (!wasDeflected) ways.press(STICK, now.motion);
    else if (!input.deflect(STICK, now.motion)) this.#disarm();
  }

  #disarm(): void {
    const { input } = this.options;
    this.#isDeflected = false;
    input.release(STICK);
    for (const one of DIRECTIONS) input.release(crossHolder(one));
    if (this.#state.isReady) this.#set({ isReady: false });
  }

  #set(change: Partial<PadState>): void {
    this.#state = { ...this.#state, ...change };
    this.options.changed(this.#state);
  }
}
