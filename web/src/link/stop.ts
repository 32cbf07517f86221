import { post } from "./http";

const STOP_MS = 5000;

/**
 * Presses Stop by HTTP, beside the state channel: neither waits for the other, and this one goes
 * on when the page does not. It resolves when the stop is latched; throws `RequestError`.
 */
export async function postStop(client: string): Promise<void> {
  const signal = AbortSignal.timeout(STOP_MS);
  await post("/api/stop", { client }, { keepalive: true, priority: "high", signal });
}

/** Releases the stop with this number where there is no channel; throws `RequestError`. */
export async function postRelease(client: string, stop: number): Promise<void> {
  await post("/api/release", { client, stop });
}
