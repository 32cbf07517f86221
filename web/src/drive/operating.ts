/** Which of the robot's controls besides driving are held or set; sent by `operateSender.ts`. */

import type { ControlInfo, Operate, Operated, Sentence } from "../messages";
import type { State } from "../state";
import type { InputState } from "./inputState";
import { OperateSender } from "./operateSender";

export interface OperatingOptions {
  state: State;
  input: InputState;
  serverMs: () => number | null;
  beat: () => string | null;
  send: (operate: Operate, urgent: boolean) => void;
  /** Shows why a control has no effect; null if the command did not arrive. */
  refused: (why: Sentence | null) => void;
}

interface Hold {
  name: string;
  /** Null for a slider that is held but was not moved yet. */
  value: number | null;
  moves: boolean;
}

/** As in `InputState`: a slider does not report every release. */
const TOUCH_MS = 300;
/** As many as fit into a message, and one hand. */
const MOST_HELD = 4;

/**
 * The robot's controls besides driving: which are held, by which holder, and which are set.
 *
 * A control that moves something is held in `InputState`, too: it counts as driving, and whatever
 * releases that releases it. One that only lights or sounds is held here alone.
 */
export class Operating {
  #held = new Map<string, Hold>();
  #touches = new Map<string, ReturnType<typeof setTimeout>>();
  readonly #sender: OperateSender;

  constructor(private readonly options: OperatingOptions) {
    const { state } = options;
    this.#sender = new OperateSender({
      ...options,
      held: () => this.#values(),
      turn: () => state.drivingTurn.peek() ?? 0,
      hung: () => this.releaseAll(),
      wants: (wanted) => {
        state.wantedControls.value = wanted;
      },
    });
    // Nothing stays held through the beginning or end of a turn, a stop or a lost link.
    state.drivingTurn.subscribe(() => this.#end());
    state.isConnected.subscribe(() => this.#end());
    state.stopNumber.subscribe(() => this.releaseAll());
    state.room.subscribe((room) => this.#sender.confirm(room?.controls ?? {}));
  }

  /** Starts to hold a button, or a slider that moves something; that acts only once it is slid. */
  press(holder: string, name: string): void {
    const control = this.#usable(name);
    if (!control || this.#held.has(holder)) return;
    if (control.moves) {
      this.options.input.press(holder, null);
      if (!this.options.input.isHeldBy(holder)) return;
    }
    const value = control.kind === "button" ? 1 : null;
    this.#held.set(holder, { name, value, moves: control.moves });
    this.#changed(true);
  }

  /** Returns false if this holder held nothing. */
  release(holder: string): boolean {
    const hold = this.#held.get(holder);
    if (!hold) return false;
    this.#held.delete(holder);
    clearTimeout(this.#touches.get(holder));
    this.#touches.delete(holder);
    if (hold.moves) this.options.input.release(holder);
    this.#changed(false);
    return true;
  }

  releaseAll(): void {
    for (const holder of [...this.#held.keys()]) this.release(holder);
  }

  /** Releases everything, and sends that three times within the same task. */
  letGo(): void {
    if (this.#held.size === 0) return;
    this.releaseAll();
    this.#sender.repeatAtOnce();
  }

  /** Handles a slider: one that moves something is held while touched, any other is set. */
  slide(name: string, value: number): void {
    const control = this.#usable(name);
    if (!control) return;
    if (!control.moves) {
      this.set(name, value);
      return;
    }
    const holders = [...this.#held].filter(([, hold]) => hold.name === name);
    if (holders.length === 0) {
      // Slid without finger or key, as assistive technology may.
      const holder = `touch ${name}`;
      this.press(holder, name);
      const hold = this.#held.get(holder);
      if (hold) holders.push([holder, hold]);
    }
    for (const [holder, hold] of holders) {
      hold.value = value;
      if (holder === `touch ${name}`) this.#touch(holder);
    }
    if (holders.length > 0) this.#changed(true);
  }

  set(name: string, value: number): void {
    if (this.#usable(name)) this.#sender.set(name, value);
  }

  /** Flips a toggle from what it shows. */
  toggle(name: string): void {
    const { wantedControls, room } = this.options.state;
    const shown = wantedControls.peek()[name] ?? room.peek()?.controls[name] ?? 0;
    this.set(name, shown === 0 ? 1 : 0);
  }

  /** Releases the moving controls whose holders `InputState` has released. */
  inputChanged(): void {
    const { input } = this.options;
    const gone = [...this.#held].filter(([holder, { moves }]) => moves && !input.isHeldBy(holder));
    for (const [holder] of gone) this.release(holder);
  }

  /** Handles the server's answer; a refusal releases everything, so that it is not sent again. */
  answered(operated: Operated): void {
    if (this.#sender.answered(operated)) this.releaseAll();
  }

  #end(): void {
    this.releaseAll();
    this.#sender.forget();
  }

  #usable(name: string): ControlInfo | undefined {
    return this.options.state.usableControls.peek().find((one) => one.name === name);
  }

  #values(): Record<string, number> {
    const values: Record<string, number> = {};
    for (const { name, value } of this.#held.values()) {
      if (value !== null && Object.keys(values).length < MOST_HELD) values[name] = value;
    }
    return values;
  }

  #touch(holder: string): void {
    clearTimeout(this.#touches.get(holder));
    this.#touches.set(
      holder,
      setTimeout(() => this.release(holder), TOUCH_MS),
    );
  }

  /** Sends first, then updates the signal. */
  #changed(isPress: boolean): void {
    if (isPress) this.#sender.send();
    else this.#sender.repeat();
    const names = [...this.#held.values()].map(({ name }) => name);
    this.options.state.heldControls.value = new Set(names);
  }
}
