import type { Drive } from "../messages";
import type { State } from "../state";
import { type Direction, fingerHolder, Hands } from "./hands";
import { listenKeyboard } from "./keyboard";
import { Pump } from "./pump";
import type { Way } from "./rate";
import { listenRelease } from "./release";

const DIRECTIONS: Direction[] = ["forward", "back", "left", "right"];

export interface HelmOptions {
  state: State;
  serverMs: () => number | null;
  seenServerMs: () => number | null;
  way: () => Way;
  send: (drive: Drive, urgent: boolean) => void;
}

/**
 * The hands and what carries them to the server. A turn begins with empty hands and untouched
 * axes, and ends with both; a stop empties the hands, and what is held through it stays released.
 */
export class Helm {
  readonly hands: Hands;
  readonly #pump: Pump;

  constructor(private readonly options: HelmOptions) {
    const { state } = options;
    this.hands = new Hands(() => this.#changed());
    this.#pump = new Pump({
      ...options,
      hung: () => this.hands.releaseAll(),
      controls: () => ({
        motion: this.hands.motion,
        held: this.hands.isHolding,
        speed: state.preferences.peek().speed,
        axes: this.hands.axes,
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

  /** Hears the keyboard, and all that takes the hands away; `stop` is the operator's, on Space. */
  listen(window: Window, stop: () => void, signal: AbortSignal): void {
    const { hands } = this;
    const { state } = this.options;
    const letGo = () => this.letGo();
    const isDriving = () => state.drivingTurn.peek() !== null;
    const lift = (pointerId: number) => hands.release(fingerHolder(pointerId));
    listenKeyboard(window, { hands, isDriving, stop, letGo, signal });
    listenRelease(window, { letGo, lift, signal });
  }

  /** Lets go of everything, and says so three times in this very task. */
  letGo(): void {
    this.hands.releaseAll();
    this.#pump.insistNow();
  }

  /** The speed was chosen anew. */
  paced(): void {
    this.#pump.send();
  }

  /** A slider was changed, which is a hand on its axis. */
  setAxis(name: string, position: number): void {
    const { axes } = this.options.state;
    this.hands.touch(name, position);
    axes.value = { ...axes.peek(), [name]: position };
  }

  /** First the wire, then whatever follows the signals. */
  #changed(): void {
    const { hands } = this;
    const { state } = this.options;
    if (hands.isHolding) {
      this.#pump.send();
      state.isFreshlyReleased.value = false;
    } else {
      this.#pump.insist();
    }
    state.held.value = new Set(DIRECTIONS.filter((one) => hands.holds(one)));
  }

  #begin(turn: number | null): void {
    const { state } = this.options;
    state.axes.value = {};
    // While the channel is still there, it carries what the hands let go of.
    this.hands.disable();
    this.#pump.end();
    const hello = state.hello.peek();
    if (turn !== null && hello) this.#pump.begin(turn, hello.command_rate_hz);
    this.#allow(state.mayMove.peek());
  }

  #allow(may: boolean): void {
    if (may) this.hands.enable();
    else this.hands.disable();
  }
}
