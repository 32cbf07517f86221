import { post, timed } from "../link/http";
import type { Sent } from "../link/signalling";
import type { ViewerInfo } from "../messages";

export type Wants = "join" | "leave" | "here" | "stay";

const ASK_MS = 5000;

/**
 * Asks the robot's server for a place in the queue, or keeps or leaves it, from a page that has no
 * connection there; returns this page's line in the room. An empty name is none. Throws
 * `RequestError`.
 */
export async function postQueue(client: string, wants: Wants, name: string): Promise<ViewerInfo> {
  const signal = AbortSignal.timeout(ASK_MS);
  const body = { client, wants, ...(name && { name }) };
  return (await post("api/queue", body, { signal })) as unknown as ViewerInfo;
}

/** Renews this page's seat in the rooms; returns fresh tokens. Throws `RequestError`. */
export async function postSeat(client: string): Promise<Sent> {
  const signal = AbortSignal.timeout(ASK_MS);
  return (await timed(post("api/seat", { client }, { signal }))) as unknown as Sent;
}

/** Gives the seat back; it is sent even while the page is closed. */
export function postLeave(client: string): void {
  // Nobody is there any more to be told that it failed.
  post("api/seat", { client, leaves: true }, { keepalive: true }).catch(() => {});
}
