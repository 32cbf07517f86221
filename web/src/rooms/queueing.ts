import { post, timed } from "../link/http";
import type { Sent } from "../link/signalling";
import type { Bodies, ViewerInfo } from "../messages";

export type Wants = Bodies["api/queue"]["wants"];

const ASK_MS = 5000;

/**
 * Joins, keeps or leaves a place in the robot's queue, from a page without a connection to its
 * server; returns this page's entry in the room state. An empty name is none. Throws
 * `RequestError`.
 */
export async function postQueue(client: string, wants: Wants, name: string): Promise<ViewerInfo> {
  const signal = AbortSignal.timeout(ASK_MS);
  const body = { client, wants, ...(name && { name }) };
  return await post("api/queue", body, { signal });
}

/** Renews this page's seat in the LiveKit rooms; returns fresh tokens. Throws `RequestError`. */
export async function postSeat(client: string): Promise<Sent> {
  const signal = AbortSignal.timeout(ASK_MS);
  return await timed(post("api/seat", { client }, { signal }));
}

/** Gives the seat back; the request survives the page being closed. */
export function postLeave(client: string): void {
  // Nobody is left to see an error.
  post("api/seat", { client, leaves: true }, { keepalive: true }).catch(() => {});
}
