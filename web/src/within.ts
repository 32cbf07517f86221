/** Bounds the browser's own promises, some of which some browsers never settle. */

import { pageSentence, type Saying, said } from "./words/said";

/** The longest that a step of the browser's own may take; usually it takes milliseconds. */
export const STEP_MS = 4000;

/** The browser has not settled a promise in time; `saying` tells the user which. */
export class Unsettled extends Error {
  readonly saying: Saying;

  constructor(api: string) {
    const saying = pageSentence("link.browser_hangs", { api });
    super(said(saying)); // for the console
    this.saying = saying;
  }
}

/** Settles as `step` does, or after `ms` rejects with `Unsettled`, which names `api`. */
export function within<T>(api: string, step: Promise<T>, ms = STEP_MS): Promise<T> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Unsettled(api)), ms);
    step.finally(() => clearTimeout(timer)).then(resolve, reject);
  });
}
