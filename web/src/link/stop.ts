/** Stop and its release by HTTP; when, and what goes by the channel: `drive/stopControl.ts`. */

import { post } from "./http";

const STOP_MS = 5000;

/**
 * Presses Stop by HTTP, in parallel with the state channel; the request survives the page being
 * closed. It resolves when the stop is latched; throws `RequestError`.
 */
export async function postStop(client: string): Promise<void> {
  const signal = AbortSignal.timeout(STOP_MS);
  await post("api/stop", { client }, { keepalive: true, priority: "high", signal });
}

/** Releases the stop with this number when there is no channel; throws `RequestError`. */
export async function postRelease(client: string, stop: number): Promise<void> {
  await post("api/release", { client, stop });
}
