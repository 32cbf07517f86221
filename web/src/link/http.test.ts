import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { german } from "../words/de";
import { said, says } from "../words/said";
import { ENGLISH, language } from "../words/words";
import { ask, type RequestError } from "./http";

const fetching = vi.fn();

beforeEach(() => {
  fetching.mockReset();
  vi.stubGlobal("fetch", fetching);
});

afterEach(() => {
  language.value = ENGLISH;
});

function refuses(body: string, status = 403): void {
  fetching.mockResolvedValue(new Response(body, { status }));
}

it("says in the reader's language why the server refuses", async () => {
  refuses('{"error": "This invitation is over.", "sentence": {"code": "invitation.over"}}');
  language.value = german;
  await expect(ask("api/enter")).rejects.toThrow("Diese Einladung ist abgelaufen");
});

it("shows the server's English until the page has its own words", async () => {
  const english = "The only place is taken; try again later.";
  const sentence = { code: "door.full", values: { n: 1 } };
  refuses(JSON.stringify({ error: english, sentence }), 503);
  const refusal = await ask("/api/offer").catch((error: RequestError) => error);
  const { saying } = refusal as RequestError;
  expect(saying).toEqual({ ...sentence, english });
  language.value = german;
  expect(said(saying)).toBe("Der einzige Platz ist belegt; versuch es später noch einmal.");
});

it("shows a plain text, as from a proxy, or at least the status", async () => {
  refuses('{"error": "Come back on Monday."}');
  await expect(ask("api/offer")).rejects.toThrow("Come back on Monday.");
  refuses("<h1>Bad Gateway</h1>", 502);
  await expect(ask("api/offer")).rejects.toThrow("502");
  refuses('{"error": 3, "sentence": {"code": 3}}', 500);
  await expect(ask("api/offer")).rejects.toThrow("500");
});

it("keeps the sentence for a page that may not stay", async () => {
  refuses('{"error": "Closed.", "sentence": {"code": "door.closed"}, "ended": true}');
  const text = { code: "door.closed" };
  const ended = { type: "ended", text, openings: [] };
  await expect(ask("api/offer")).rejects.toMatchObject({ ended });
  const opening = { opens_wall_ms: 5, closes_wall_ms: 6 };
  const openings = [null, 7, { opens_wall_ms: "5", closes_wall_ms: 6 }, opening];
  refuses(JSON.stringify({ sentence: text, ended: true, openings }));
  await expect(ask("api/offer")).rejects.toMatchObject({
    ended: { ...ended, openings: [opening] },
  });
  refuses('{"error": "Closed.", "ended": true}');
  await expect(ask("api/offer")).rejects.toMatchObject({ ended: { text: says("Closed.") } });
});
