import { afterEach, expect, it, vi } from "vitest";
import { RequestError } from "./http";
import { askIce, postOffer } from "./signalling";

const signal = new AbortController().signal;

function answer(status: number, body: string): void {
  vi.stubGlobal("fetch", async () => new Response(body, { status }));
}

afterEach(() => vi.unstubAllGlobals());

it("posts offer and client as JSON and returns the answer's text", async () => {
  const fetching = vi.fn(async () => new Response('{"sdp": "v=0 answer"}'));
  vi.stubGlobal("fetch", fetching);
  expect(await postOffer("v=0", "some-uuid", signal)).toBe("v=0 answer");
  expect(fetching).toHaveBeenCalledWith(
    "/api/offer",
    expect.objectContaining({ method: "POST", body: '{"sdp":"v=0","client":"some-uuid"}' }),
  );
});

it("passes on the server's sentence when the offer is refused", async () => {
  answer(503, '{"error": "All 100 places are taken; try again later."}');
  await expect(postOffer("v=0", "c", signal)).rejects.toThrow(
    new RequestError("All 100 places are taken; try again later.", true),
  );
});

it("says a sentence of its own when the answer is none of ours", async () => {
  answer(502, "<html>Bad gateway</html>");
  await expect(postOffer("v=0", "c", signal)).rejects.toThrow("The server answered 502.");
});

it("says so when nobody answers", async () => {
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  await expect(postOffer("v=0", "c", signal)).rejects.toThrow("The server cannot be reached.");
});

it("waits two seconds for the ICE servers and no longer", async () => {
  const asking = new AbortController();
  const timeout = vi.spyOn(AbortSignal, "timeout").mockReturnValue(asking.signal);
  vi.stubGlobal("fetch", (_url: string, { signal }: RequestInit) => {
    return new Promise((_resolve, reject) => {
      signal?.addEventListener("abort", () => reject(signal.reason));
    });
  });
  const asked = askIce();
  expect(timeout).toHaveBeenCalledWith(2000);
  asking.abort();
  expect(await asked).toEqual({ servers: [], relayOnly: false, wantsCandidates: false });
});

it("goes on without ICE servers when it cannot learn of any", async () => {
  answer(
    200,
    '{"iceServers": [{"urls": "stun:example.org"}], "relayOnly": true, "wantsCandidates": true}',
  );
  const servers = [{ urls: "stun:example.org" }];
  expect(await askIce()).toEqual({ servers, relayOnly: true, wantsCandidates: true });
  const none = { servers: [], relayOnly: false, wantsCandidates: false };
  answer(404, "");
  expect(await askIce()).toEqual(none);
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  expect(await askIce()).toEqual(none);
});
