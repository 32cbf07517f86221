import type { Drive } from "../messages";
import type { State } from "../state";
import { CommandSender } from "./commandSender";
import { type Direction, fingerHolder, InputState } from "./inputState";
import { listenKeyboard } from "./keyboard";
import { listenLetGo } from "./letGo";
import type { Uplink } from "./rate";

const DIRECTIONS: Direction[] = ["forward", "back", "left", "right"];

export interface DriveControllerOptions {
  state: State;
  serverMs: () => number | null;
  seenServerMs: () => number | null;
  uplink: () => Uplink;
  send: (drive: Drive, urgent: boolean) => void;
}

/**
 * Connects the input to the command sender. A turn begins and ends with nothing held and no axis
 * touched; a stop releases everything, including what is physically still held.
 */
export class DriveController {
  readonly input: InputState;
  readonly #sender: CommandSender;

  constructor(private readonly options: DriveControllerOptions) {
    const { state } = options;
    this.input = new InputState(() => this.#changed());
    this.#sender = new CommandSender({
      ...options,
      hung: () => this.input.releaseAll(),
      controls: () => ({
        motion: this.input.motion,
        held: this.input.isHolding,
        speed: state.preferences.peek().speed,
        axes: this.input.axes,
      }),
    });
    state.drivingTurn.subscribe((turn) => this.#begin(turn));
    state.mayMove.subscribe((may) => this.#allow(may));
    let latched: number | null = null;
    state.stopNumber.subscribe((number) => {
      const isReleased = latched !== null && number === null;
      state.isFreshlyReleased.value = isReleased && state.drivingTurn.peek() !== null;
      latched = number;
    });
  }

  /** Listens to the keyboard and to events that end input; `stop` is the operator's, on Space. */
  listen(window: Window, stop: () => void, signal: AbortSignal): void {
    const { input } = this;
    const { state } = this.options;
    const letGo = () => this.letGo();
    const isDriving = () => state.drivingTurn.peek() !== null;
    const lift = (pointerId: number) => input.release(fingerHolder(pointerId));
    listenKeyboard(window, { input, isDriving, stop, letGo, signal });
    listenLetGo(window, { letGo, lift, signal });
  }

  /** What is known of the uplink now. */
  uplink(): Uplink {
    return this.options.uplink();
  }

  /** Releases everything, and sends that three times within the same task. */
  letGo(): void {
    this.input.releaseAll();
    this.#sender.insistNow();
  }

  /** Handles a change of the speed. */
  paced(): void {
    this.#sender.send();
  }

  /** Handles a change of a slider, which counts as holding its axis. */
  setAxis(name: string, position: number): void {
    const { axes } = this.options.state;
    this.input.touch(name, position);
    axes.value = { ...axes.peek(), [name]: position };
  }

  /** Sends first, then updates the signals. */
  #changed(): void {
    const { input } = this;
    const { state } = this.options;
    if (input.isHolding) {
      this.#sender.send();
      state.isFreshlyReleased.value = false;
    } else {
      this.#sender.insist();
    }
    state.held.value = new Set(DIRECTIONS.filter((one) => input.holds(one)));
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
