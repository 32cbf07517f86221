/** Connects all input to the sender; what is held: `inputState.ts`, what ends it: `letGo.ts`. */

import { computed, effect } from "@preact/signals";
import type { Drive, Operate, Sentence } from "../messages";
import type { State } from "../state";
import { AxisKeys } from "./axisKeys";
import { CommandSender } from "./commandSender";
import { listenControlKeys } from "./controlKeys";
import { wayInForce } from "./drivePreferences";
import type { PadWish } from "./gamepad";
import { Gamepads, type PadNews } from "./gamepads";
import { DIRECTIONS, fingerHolder, InputState, type Motion } from "./inputState";
import { KeyActions } from "./keyActions";
import { listenKeyboard } from "./keyboard";
import { listenLetGo } from "./letGo";
import { Operating } from "./operating";
import { type ScanItem, Scanner } from "./scanner";
import type { Uplink } from "./sendRate";
import { Ways } from "./ways";

export interface DriveControllerOptions {
  state: State;
  serverMs: () => number | null;
  beat: () => string | null;
  seenServerMs: () => number | null;
  uplink: () => Uplink;
  send: (drive: Drive, urgent: boolean) => void;
  /** Sends which of the robot's controls are held and set. */
  operate: (operate: Operate, urgent: boolean) => void;
  /** Shows why one of the robot's controls has no effect; null if the command did not arrive. */
  refused: (why: Sentence | null) => void;
}

/** What keys, switches and gamepads can do besides driving. */
export interface DriveCallbacks {
  /** The operator's Stop. */
  stop: () => void;
  releaseStop: () => void;
  toggleSpeed: () => void;
  tellOfPad: (what: PadNews) => void;
}

/**
 * Connects the input to the command sender. A turn begins and ends with nothing held and no axis
 * touched; a stop releases everything, even what is physically still held.
 */
export class DriveController {
  readonly input: InputState;
  readonly ways: Ways;
  /** The robot's controls besides driving. */
  readonly operating: Operating;
  readonly #sender: CommandSender;
  #scanner: Scanner | null = null;
  #gamepads: Gamepads | null = null;

  constructor(private readonly options: DriveControllerOptions) {
    const { state } = options;
    this.input = new InputState({
      changed: () => this.#changed(),
      deflected: () => {
        this.#sender.deflected();
        state.motion.value = this.input.motion;
      },
      movesSideways: () => state.movesSideways.peek(),
    });
    this.ways = new Ways({
      input: this.input,
      way: () => this.#way(),
      stepMs: () => state.preferences.peek().stepMs,
    });
    this.#sender = new CommandSender({
      ...options,
      hung: () => this.input.releaseAll(),
      controls: () => ({
        motion: this.input.motion,
        held: this.input.isHolding,
        speed: this.ways.isStepping ? "slow" : state.preferences.peek().speed,
        axes: this.input.axes,
      }),
    });
    this.operating = new Operating({ ...options, send: options.operate, input: this.input });
    state.drivingTurn.subscribe((turn) => this.#begin(turn));
    state.mayMove.subscribe((may) => this.#allow(may));
    let latched: number | null = null;
    state.stopNumber.subscribe((number) => {
      const isReleased = latched !== null && number === null;
      state.isFreshlyReleased.value = isReleased && state.drivingTurn.peek() !== null;
      latched = number;
    });
  }

  /** Listens to the keyboard, switches and gamepads, and to events that end input. */
  listen(window: Window, callbacks: DriveCallbacks, signal: AbortSignal): void {
    const { input, ways } = this;
    const { state } = this.options;
    const letGo = () => this.letGo();
    const isDriving = () => state.drivingTurn.peek() !== null;
    const scanner = this.#listenToSwitches(callbacks, signal);
    const keyActions = new KeyActions({
      ...callbacks,
      ways,
      way: () => this.#way(),
      scanner,
      axisKeys: new AxisKeys({
        input,
        position: (axis) => state.axes.peek()[axis] ?? 0,
        setAxis: (axis, position) => this.setAxis(axis, position),
      }),
      axes: () => this.#axes(),
      recentre: () => this.recentre(),
    });
    listenKeyboard(window, {
      keys: () => state.keys.peek(),
      isDriving,
      isFor: (action) => keyActions.isFor(action),
      press: (holder, action) => keyActions.press(holder, action),
      release: (holder) => void ways.release(holder),
      anyKey: () => ways.interrupt(),
      letGo,
      signal,
    });
    listenControlKeys(window, {
      operating: this.operating,
      controls: () => state.usableControls.peek(),
      keys: () => state.keys.peek(),
      signal,
    });
    const onPointer = (event: Event) => {
      if (!event.defaultPrevented) ways.interrupt();
    };
    window.addEventListener("pointerdown", onPointer, { signal });
    const lift = (pointerId: number, isCancelled: boolean) => {
      const holder = fingerHolder(pointerId);
      const isControl = this.operating.release(holder);
      return (isCancelled ? ways.cancel(holder) : ways.release(holder)) || isControl;
    };
    listenLetGo(window, { letGo, lift, signal });
    this.#gamepads = new Gamepads(window, {
      ...callbacks,
      input,
      ways,
      operating: this.operating,
      controls: () => state.usableControls.peek(),
      settings: () => state.preferences.peek().gamepad,
      movesSideways: () => state.movesSideways.peek(),
      isDriving,
      changed: (pads) => {
        state.pads.value = pads;
      },
      tell: callbacks.tellOfPad,
    });
    this.#gamepads.listen(signal);
  }

  /** What is known of the uplink now. */
  uplink(): Uplink {
    return this.options.uplink();
  }

  /** Releases everything, and sends that three times within the same task. */
  letGo(): void {
    this.operating.letGo();
    this.input.releaseAll();
    this.#sender.repeatAtOnce();
  }

  /** Sends a changed speed. */
  speedChanged(): void {
    this.#sender.send();
  }

  /** Moves the stick that this holder still holds; returns false if it holds none any more. */
  deflect(holder: string, motion: Motion): boolean {
    return this.input.deflect(holder, motion);
  }

  /** Moves an axis by its slider, which counts as holding the axis. */
  setAxis(name: string, position: number): void {
    const { axes } = this.options.state;
    this.input.touch(name, position);
    axes.value = { ...axes.peek(), [name]: position };
  }

  /** Returns all axes to their middle. */
  recentre(): void {
    for (const axis of this.#axes()) this.setAxis(axis, 0);
  }

  /** Drives with this gamepad from now on; null for none. */
  useGamepad(index: number | null): void {
    this.#gamepads?.input?.use(index);
  }

  /** Where the axes of the gamepad in use rest if released now; null unless they are still. */
  padRestNow(): readonly number[] | null {
    return this.#gamepads?.input?.restNow() ?? null;
  }

  /** Lets the user choose a part of the gamepad in use by pressing it; null ends that. */
  learnPad(wish: PadWish | null): void {
    this.#gamepads?.input?.learn(wish);
  }

  /** Chooses what is offered, or offers the next, by the buttons on the screen. */
  scan(what: "select" | "next"): void {
    this.#scanner?.[what]();
  }

  /** Offers the directions in turn while this page drives by scanning. */
  #listenToSwitches({ stop, releaseStop }: DriveCallbacks, signal: AbortSignal): Scanner {
    const { state } = this.options;
    const scanner = new Scanner({
      dwellMs: () => {
        const { switches, dwellMs } = state.preferences.peek();
        return switches === 1 ? dwellMs : null;
      },
      movesSideways: () => state.movesSideways.peek(),
      offer: (item) => {
        state.scan.value = item;
      },
      choose: (item: ScanItem) => {
        if (item === "stop") stop();
        else if (item === "release") releaseStop();
        else this.ways.step("switch", item);
      },
    });
    this.#scanner = scanner;
    const isScanning = computed(
      () =>
        state.drivingTurn.value !== null &&
        wayInForce(state.preferences.value, state.hello.value?.click_to_move) === "scan",
    );
    const switches = computed(() => state.preferences.value.switches);
    const end = effect(() => {
      const isStopped = state.stopNumber.value !== null;
      // A second switch replaces the dwell time.
      void switches.value;
      if (isScanning.value) scanner.begin(isStopped);
      else scanner.end();
    });
    signal.addEventListener("abort", () => {
      end();
      scanner.end();
    });
    return scanner;
  }

  #way() {
    const { preferences, hello } = this.options.state;
    return wayInForce(preferences.peek(), hello.peek()?.click_to_move);
  }

  #axes(): readonly string[] {
    return this.options.state.hello.peek()?.robot.axes ?? [];
  }

  /** Sends first, then updates the signals. */
  #changed(): void {
    const { input } = this;
    const { state } = this.options;
    if (input.isHolding) {
      this.#sender.send();
      state.isFreshlyReleased.value = false;
    } else {
      this.#sender.repeat();
    }
    this.operating.inputChanged();
    state.held.value = new Set(DIRECTIONS.filter((one) => input.holds(one)));
    state.motion.value = input.motion;
    state.isHolding.value = input.isHolding;
  }

  #begin(turn: number | null): void {
    const { state } = this.options;
    state.axes.value = {};
    // Send the release while the channel still exists.
    this.input.disable();
    this.#sender.end();
    const hello = state.hello.peek();
    if (turn !== null && hello) this.#sender.begin(turn, hello.command_rate_hz);
    this.#allow(state.mayMove.peek());
  }

  #allow(may: boolean): void {
    if (may) this.input.enable();
    else this.input.disable();
  }
}
