/** HTTP requests to the server, with errors as sentences for users. */

import { isFramed } from "../framed";
import type { Answers, Bodies, Ended, Opening } from "../messages";
import { isSentence, pageSentence, type Saying, said, says } from "../words/said";

/** The server refused (`isRefusal`) or did not answer. */
export class RequestError extends Error {
  constructor(
    readonly saying: Saying,
    readonly isRefusal: boolean,
    /** How long the server asks to wait before the next request; null if it does not. */
    readonly retryAfterMs: number | null = null,
    /** Set if the page may not stay, so that it does not retry by itself. */
    readonly ended: Ended | null = null,
    /** Whether our own server has refused with a reason, so that a retry is useless. */
    readonly isFinal = false,
  ) {
    super(said(saying)); // for the console; the page shows the saying
  }
}

export const JSON_TYPE = { "Content-Type": "application/json" };

/** Posts JSON and returns the JSON answer; throws `RequestError`. */
export function post<P extends keyof Bodies>(
  path: P,
  body: Bodies[P],
  init: RequestInit = {},
): Promise<Answer<P>> {
  return ask(path, { method: "POST", headers: JSON_TYPE, body: JSON.stringify(body), ...init });
}

/** A request with a long JSON body, compressed where the browser can do that. */
export async function packed(body: Bodies["api/offer"]): Promise<RequestInit> {
  const text = JSON.stringify(body);
  if (typeof CompressionStream === "undefined")
    return { method: "POST", headers: JSON_TYPE, body: text };
  const bytes = new Blob([text]).stream().pipeThrough(new CompressionStream("gzip"));
  const headers = { ...JSON_TYPE, "Content-Encoding": "gzip" };
  return { method: "POST", headers, body: await new Response(bytes).blob() };
}

/** What our server answers at this path; a captive portal may answer anything. */
export type Answer<P extends string> = P extends keyof Answers
  ? Answers[P]
  : Record<string, unknown>;

/** When a request was sent and when its answer arrived, by the page's clock. */
export interface Asked {
  sentMs: number;
  receivedMs: number;
}

/** Returns the answer with the times of request and answer. */
export async function timed<A>(asking: Promise<A>): Promise<A & Asked> {
  const sentMs = performance.now();
  const answer = await asking;
  return { ...answer, sentMs, receivedMs: performance.now() };
}

/** Requests the JSON object at this path; throws `RequestError`. */
export async function ask<P extends string>(path: P, init: RequestInit = {}): Promise<Answer<P>> {
  let response: Response;
  try {
    // In a frame on another site cookies are not used, even where the browser would send them.
    response = await fetch(path, isFramed() ? { ...init, credentials: "omit" } : init);
  } catch {
    throw new RequestError(pageSentence("link.unreachable"), false);
  }
  const body = await response.json().catch(() => null);
  if (response.ok && body !== null) return body;
  const why = told(body);
  const sentence = why ?? pageSentence("link.answered", { status: String(response.status) });
  const ended = body?.ended === true ? endedFor(sentence, body.openings) : null;
  // A 5xx, or an answer from something between us and the server, may be temporary.
  const isFinal = why !== null && response.status >= 400 && response.status < 500;
  throw new RequestError(sentence, true, retryAfterMs(response), ended, isFinal);
}

/** Why the request was refused; a proxy in between may answer in plain words. */
function told(body: { sentence?: unknown; error?: unknown } | null): Saying | null {
  const english = typeof body?.error === "string" ? body.error : null;
  if (isSentence(body?.sentence)) return english ? { ...body.sentence, english } : body.sentence;
  return english === null ? null : says(english);
}

function endedFor(text: Saying, openings: unknown): Ended {
  return {
    type: "ended",
    text,
    openings: Array.isArray(openings) ? openings.filter(isOpening) : [],
  };
}

function isOpening(one: unknown): one is Opening {
  const { opens_wall_ms, closes_wall_ms } = (one ?? {}) as Partial<Opening>;
  return typeof opens_wall_ms === "number" && typeof closes_wall_ms === "number";
}

/** The seconds in `Retry-After` (RFC 9110, 10.2.3) as ms; our server sends no dates. */
function retryAfterMs(response: Response): number | null {
  const text = response.headers.get("Retry-After") ?? "";
  return /^\d+$/.test(text) ? Number(text) * 1000 : null;
}
