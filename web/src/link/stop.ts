/** Stop and its release by HTTP; when, and over which transport: `drive/stopControl.ts`. */

import { pageSentence } from "../words/said";
import { JSON_TYPE, post, RequestError } from "./http";

const STOP_MS = 5000;
/** The header with the tab's secret, by which the server knows a page without cookies. */
const TAB = "WAX-Tab";

/**
 * Presses Stop by HTTP, in parallel with the state channel; the request survives the page being
 * closed. Returns the number of the stop, once it is latched; throws `RequestError`. The server
 * counts a `press` once, however often it arrives.
 */
export async function postStop(client: string, press: number): Promise<number> {
  const signal = AbortSignal.timeout(STOP_MS);
  const { stop } = await post(
    "api/stop",
    { client, press },
    { keepalive: true, priority: "high", signal, headers: { ...JSON_TYPE, [TAB]: client } },
  );
  if (typeof stop === "number") return stop;
  // A captive portal answers every request.
  throw new RequestError(pageSentence("link.no_answer"), false);
}

/** Releases the stop with this number when there is no channel; throws `RequestError`. */
export async function postRelease(client: string, stop: number): Promise<void> {
  await post("api/release", { client, stop });
}
