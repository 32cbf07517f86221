import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { german } from "../words/de";
import { says } from "../words/said";
import { ENGLISH, language } from "../words/words";
import { ask } from "./http";

const fetching = vi.fn();

beforeEach(() => {
  fetching.mockReset();
  vi.stubGlobal("fetch", fetching);
});

afterEach(() => {
  vi.unstubAllGlobals();
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

it("says in plain words what comes so, as from a proxy, or at least the status", async () => {
  refuses('{"error": "Come back on Monday."}');
  await expect(ask("api/offer")).rejects.toThrow("Come back on Monday.");
  refuses("<h1>Bad Gateway</h1>", 502);
  await expect(ask("api/offer")).rejects.toThrow("502");
  refuses('{"error": 3, "sentence": {"code": 3}}', 500);
  await expect(ask("api/offer")).rejects.toThrow("500");
});

it("keeps the sentence of who may not stay, to be shown for long", async () => {
  refuses('{"error": "Closed.", "sentence": {"code": "door.closed"}, "ended": true}');
  const text = { code: "door.closed" };
  const ended = { type: "ended", text, opens_wall_ms: null };
  await expect(ask("api/offer")).rejects.toMatchObject({ ended });
  refuses('{"error": "Closed.", "ended": true}');
  await expect(ask("api/offer")).rejects.toMatchObject({ ended: { text: says("Closed.") } });
});
