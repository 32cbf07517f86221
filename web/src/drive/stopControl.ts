/** How Stop and its release are sent (by HTTP: `../link/stop.ts`); when: `../permissions.ts`. */

import { RequestError } from "../link/http";
import type { Link } from "../link/link";
import { postRelease, postStop } from "../link/stop";
import type { State } from "../state";
import type { Saying } from "../words/said";
import { t } from "../words/words";

export interface StopControlOptions {
  state: Pick<State, "stopNumber">;
  link: Pick<Link, "sendState" | "clock" | "beat">;
  client: () => string;
  /** Releases everything at once. */
  letGo: () => void;
  /** Shows a sentence to the user. */
  say: (sentence: string | Saying) => void;
}

/** Stop for everybody, and its release. */
export class StopControl {
  constructor(private readonly options: StopControlOptions) {}

  /** Sends it by both transports at once, in any state; only then releases this page's controls. */
  stop(): void {
    const { link, client, letGo, state, say } = this.options;
    link.sendState({ type: "stop" });
    const posted = postStop(client());
    letGo();
    posted.catch((error: unknown) => {
      if (error instanceof RequestError && error.isRefusal) say(error.saying);
      else if (state.stopNumber.peek() === null) say(t("stop.not_answered"));
    });
  }

  /**
   * Releases the stop in force; this moves nothing. Over the channel it has a timestamp, so that a
   * late one has no effect.
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
