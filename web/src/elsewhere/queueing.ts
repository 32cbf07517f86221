import { post } from "../link/http";
import type { Elsewhere, ViewerInfo } from "../messages";

export type Wants = "join" | "leave" | "here" | "stay";

const ASK_MS = 5000;

/**
 * Asks the robot's server for a place in the queue, or keeps or leaves it, from a page that has no
 * connection there; returns this page's line in the room. Throws `RequestError`.
 */
export async function postQueue(client: string, wants: Wants): Promise<ViewerInfo> {
  const signal = AbortSignal.timeout(ASK_MS);
  return (await post("/api/queue", { client, wants }, { signal })) as unknown as ViewerInfo;
}

/** Renews this page's seat in the rooms; returns fresh tokens. Throws `RequestError`. */
export async function postSeat(client: string): Promise<Elsewhere> {
  const signal = AbortSignal.timeout(ASK_MS);
  return (await post("/api/seat", { client }, { signal })) as unknown as Elsewhere;
}
