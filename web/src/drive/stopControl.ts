/** How Stop and its release are sent (by HTTP: `../link/stop.ts`); when: `../permissions.ts`. */

import { RequestError } from "../link/http";
import type { Link } from "../link/link";
import { postRelease, postStop } from "../link/stop";
import type { State } from "../state";
import type { Saying } from "../words/said";
import { t } from "../words/words";
import { StopPress } from "./stopPress";

export interface StopControlOptions {
  state: Pick<State, "stopNumber" | "isConnected" | "isStopUnconfirmed">;
  link: Pick<Link, "sendState" | "clock" | "beat">;
  client: () => string;
  /** Releases everything at once. */
  letGo: () => void;
  /** Shows a sentence to the user. */
  say: (sentence: string | Saying) => void;
}

/** Presses Stop for everybody, and releases it. */
export class StopControl {
  /** The press that is not yet confirmed or refused. */
  #press: StopPress | null = null;

  constructor(private readonly options: StopControlOptions) {}

  /**
   * Sends Stop by both transports at once, in any state; only then releases this page's controls.
   * It is sent again until the server has accepted or refused it, or until `StopPress` gives up.
   * Each press is a new one, since the stop of the last one may be released by now.
   */
  stop(): void {
    const { letGo, state } = this.options;
    // Pressing again does not postpone the warning that nothing is confirmed.
    const since = this.#press?.taken === null ? this.#press.sinceMs : undefined;
    const press = new StopPress(state.stopNumber.peek(), performance.now(), since);
    this.#press = press;
    this.#send(press);
    letGo();
  }

  /** Tells the user what became of the press, and retries it; call a few times a second. */
  check(nowMs: number): void {
    const press = this.#press;
    if (!press) return;
    const { state, say } = this.options;
    const stop = state.stopNumber.peek();
    press.sawStop(stop, nowMs);
    state.isStopUnconfirmed.value = press.isUnconfirmed(nowMs);
    if (press.taken !== null) {
      const isShown = state.isConnected.peek() && stop === press.taken;
      if (!isShown && !press.isSettled(nowMs)) return;
      if (!isShown) say(t("stop.taken"));
      this.#press = null;
    } else if (press.isDue(nowMs)) {
      press.tried(nowMs);
      this.#send(press);
    }
  }

  /** Sends an open press again: it may have been lost with the previous connection. */
  connected(): void {
    if (this.#press?.mayTry(performance.now())) this.#send(this.#press);
  }

  #send(press: StopPress): void {
    const { link, client, state, say } = this.options;
    link.sendState({ type: "stop", press: press.number });
    postStop(client(), press.number).then(
      (stop) => press.answered(stop, performance.now()),
      (error: unknown) => {
        if (this.#press !== press || press.taken !== null) return;
        if (!(error instanceof RequestError && error.isFinal)) return; // it is sent again
        this.#press = null;
        state.isStopUnconfirmed.value = false;
        say(error.saying);
      },
    );
  }

  /**
   * Releases the stop in force; this moves nothing. Over the channel the release has a timestamp,
   * so that a late one has no effect.
   */
  release(): void {
    const { link, client, state, say } = this.options;
    const stop = state.stopNumber.peek();
    if (stop === null) return;
    const sentMs = link.clock.toServerMs(performance.now());
    const { beat } = link;
    if (sentMs !== null && link.sendState({ type: "release", stop, sent_server_ms: sentMs, beat }))
      return;
    postRelease(client(), stop).catch((error: unknown) => {
      if (error instanceof RequestError) say(error.saying);
    });
  }
}
