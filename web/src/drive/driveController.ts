import type { Drive } from "../messages";
import type { State } from "../state";
import { CommandSender } from "./commandSender";
import { type Direction, fingerHolder, InputState } from "./inputState";
import { listenKeyboard } from "./keyboard";
import { listenLetGo } from "./letGo";
import type { Way } from "./rate";

const DIRECTIONS: Direction[] = ["forward", "back", "left", "right"];

export interface DriveControllerOptions {
  state: State;
  serverMs: () => number | null;
  seenServerMs: () => number | null;
  way: () => Way;
  send: (drive: Drive, urgent: boolean) => void;
}

/**
 * What is held, and what sends it to the server. A turn begins and ends with nothing held and no
 * axis touched; a stop lets go of everything, and what is held through it counts as let go of.
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

  /** Listens to the keyboard, and to all that takes controls away; `stop` is the operator's, on Space. */
  listen(window: Window, stop: () => void, signal: AbortSignal): void {
    const { input } = this;
    const { state } = this.options;
    const letGo = () => this.letGo();
    const isDriving = () => state.drivingTurn.peek() !== null;
    const lift = (pointerId: number) => input.release(fingerHolder(pointerId));
    listenKeyboard(window, { input, isDriving, stop, letGo, signal });
    listenLetGo(window, { letGo, lift, signal });
  }

  /** Lets go of everything, and says so three times in this very task. */
  letGo(): void {
    this.input.releaseAll();
    this.#sender.insistNow();
  }

  /** The speed was chosen anew. */
  paced(): void {
    this.#sender.send();
  }

  /** A slider was changed, which is a hand on its axis. */
  setAxis(name: string, position: number): void {
    const { axes } = this.options.state;
    this.input.touch(name, position);
    axes.value = { ...axes.peek(), [name]: position };
  }

  /** First the wire, then whatever follows the signals. */
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
    // While the channel is still there, it carries what the hands let go of.
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
