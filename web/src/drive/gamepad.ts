/** When the chosen gamepad drives; its readings: `padReading.ts`, its doubts: `padRest.ts`. */

import type { ControlInfo } from "../messages";
import { NO_PADS, type PadNews, type PadState } from "./gamepads";
import { DIRECTIONS, type Direction, type InputState, isMoving } from "./inputState";
import type { Operating } from "./operating";
import { type Found, PadLearner } from "./padLearner";
import { layoutOf, type PadPart, type PadReading, type PadSettings, readPad } from "./padReading";
import { PadRest } from "./padRest";
import type { Ways } from "./ways";

export interface GamepadInputOptions {
  input: Pick<InputState, "isEnabled" | "release" | "deflect">;
  ways: Pick<Ways, "press" | "release">;
  settings: () => PadSettings;
  movesSideways: () => boolean;
  /** The robot's controls that may be used now. */
  controls: () => readonly ControlInfo[];
  operating: Pick<Operating, "press" | "release" | "toggle">;
  isDriving: () => boolean;
  stop: () => void;
  toggleSpeed: () => void;
  changed: (state: PadState) => void;
  /** Tells the user that unused gamepads were found, or that the one in use is lost or frozen. */
  tell: (what: PadNews) => void;
}

/** What to find on the gamepad in use, and who is told. */
export interface PadWish {
  isAxis: boolean;
  found: (part: Found) => void;
}

const STICK = "gamepad stick";
const controlHolder = (name: string) => `pad-control ${name}`;
const crossHolder = (direction: Direction) => `gamepad ${direction}`;
/** How long a new gamepad is read for a press of its Start. */
const OFFERED_MS = 20_000;
/** The poll interval while this page may drive: waiting for the next frame would delay a push. */
const DRIVING_MS = 8;
/** The poll interval otherwise, to notice what is plugged in, pressed or released. */
const LOOKING_MS = 50;

/**
 * Drives with a gamepad that the user has chosen. A timer reads it while it is in use or was just
 * found, fast while this page may drive. At first, after everything was released, after a change of
 * settings, and in doubt (`PadRest`), it moves nothing until everything on it was released once.
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
  /** The robot's controls that it has pressed. */
  readonly #operated = new Set<string>();
  #learning: { learner: PadLearner; found: PadWish["found"] } | null = null;

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

  /** Moves nothing until the user has chosen a part by pressing or pushing it; null to go on. */
  learn(wish: PadWish | null): void {
    const pad = this.#pads().find(({ index }) => index === this.#state.chosen);
    this.#learning =
      wish && pad ? { learner: new PadLearner(pad, wish.isAxis), found: wish.found } : null;
  }

  /** Drives with this gamepad from now on; null for none. */
  use(index: number | null): void {
    this.#disarm();
    this.learn(null);
    this.#last = null;
    const isThere = this.#pads().some((pad) => pad.index === index);
    this.#offeredUntilMs = 0;
    this.#set({ chosen: isThere ? index : null });
    if (this.#state.chosen === null) return;
    this.#rest = new PadRest();
    this.#read();
  }

  /** Where the axes of the one in use rest, if it is released now; null unless they are still. */
  restNow(): readonly number[] | null {
    if (!this.#last || !this.#rest.isStill(performance.now())) return null;
    const { axes, held } = this.#last;
    const rests = Array.from({ length: Math.max(2, ...axes.map(({ at }) => at)) + 1 }, () => 0);
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
    // A Start held now was pressed so that the browser finds the pad, not to choose it.
    this.#starts = new Set(this.#pads().map((pad) => pad.index));
    this.#read();
  }

  /** Lists the gamepads; drops the one in use if it is gone. */
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
      const isPressed = this.#readingOf(pad).start;
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
    // An axis inside the previous dead zone may be outside the new one.
    if (settings !== this.#settings) {
      this.#disarm();
      this.#rest = new PadRest();
    }
    this.#settings = settings;
    const now = this.#readingOf(pad);
    const last = this.#last ?? now;
    this.#last = now;
    // A page without the focus gets no keys either.
    const isInFront = !document.hidden && document.hasFocus();
    if (isInFront && this.options.isDriving() && now.stop && !last.stop) this.options.stop();
    if (this.#learning && isInFront) {
      this.#disarm();
      const { learner, found } = this.#learning;
      const part = learner.next(pad, nowMs);
      if (part) {
        this.learn(null);
        found(part);
      }
      return;
    }
    // Without the focus, browsers report old values.
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

  /** Becomes ready once nothing is held; until then shows what is held or must be moved. */
  #await(isReady: boolean, held: readonly PadPart[]): void {
    const unmoved = this.#rest.unmoved.map((at) => ({ kind: "axis" as const, at }));
    const before = JSON.stringify([this.#state.held, this.#state.unmoved]);
    if (isReady || JSON.stringify([held, unmoved]) !== before) {
      this.#set({ isReady, held, unmoved });
    }
  }

  #readingOf(pad: Gamepad): PadReading {
    const { settings, movesSideways, controls } = this.options;
    return readPad(pad, settings(), movesSideways(), controls());
  }

  #drive(now: PadReading, last: PadReading): void {
    const { input, ways, toggleSpeed } = this.options;
    if (now.speed && !last.speed) toggleSpeed();
    for (const one of DIRECTIONS) {
      const [is, was] = [now.directions.has(one), last.directions.has(one)];
      if (is && !was) ways.press(crossHolder(one), one);
      if (was && !is) ways.release(crossHolder(one));
    }
    this.#operate(now, last);
    const isDeflected = isMoving(now.motion);
    const wasDeflected = this.#isDeflected;
    this.#isDeflected = isDeflected;
    if (!isDeflected) input.release(STICK);
    else if (!wasDeflected) ways.press(STICK, now.motion);
    else if (!input.deflect(STICK, now.motion)) this.#disarm();
  }

  #operate(now: PadReading, last: PadReading): void {
    const { controls, operating } = this.options;
    for (const name of this.#operated) if (!now.controls.has(name)) this.#letGoOf(name);
    for (const { name, kind } of controls()) {
      if (!now.controls.has(name) || last.controls.has(name)) continue;
      if (kind === "toggle") operating.toggle(name);
      else operating.press(controlHolder(name), name);
      this.#operated.add(name);
    }
  }

  #letGoOf(control: string): void {
    this.#operated.delete(control);
    this.options.operating.release(controlHolder(control));
  }

  #disarm(): void {
    const { input } = this.options;
    for (const name of this.#operated) this.#letGoOf(name);
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
