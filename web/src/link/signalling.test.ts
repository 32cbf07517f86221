import { expect, it, vi } from "vitest";
import { says } from "../words/said";
import { packed, RequestError } from "./http";
import { askIce, gathered, postOffer } from "./signalling";

const signal = new AbortController().signal;

function answer(status: number, body: string): void {
  vi.stubGlobal("fetch", async () => new Response(body, { status }));
}

const PLAIN = { method: "POST", body: '{"sdp":"v=0","client":"some-uuid"}' };

it("posts offer and client as JSON and returns the answer's text", async () => {
  vi.stubGlobal("CompressionStream", undefined);
  const fetching = vi.fn(async () => new Response('{"sdp": "v=0 answer"}'));
  vi.stubGlobal("fetch", fetching);
  expect(await postOffer(await packed({ sdp: "v=0", client: "some-uuid" }), signal)).toEqual({
    sdp: "v=0 answer",
    isForHost: false,
  });
  expect(fetching).toHaveBeenCalledWith("api/offer", expect.objectContaining(PLAIN));
});

it("uses a separate path from a frame, and sends no cookie", async () => {
  vi.stubGlobal("document", { documentElement: { dataset: { view: "embed" } } });
  const fetching = vi.fn(
    async (path: string) => new Response(path === "api/ice" ? "{}" : '{"sdp": "v=0"}'),
  );
  vi.stubGlobal("fetch", fetching);
  await askIce(signal);
  await postOffer(await packed({ sdp: "v=0", client: "some-uuid" }), signal);
  const asked = fetching.mock.calls as unknown as [string, RequestInit][];
  expect(asked.map(([path, { credentials }]) => [path, credentials])).toEqual([
    ["api/ice", "omit"],
    ["api/embed", "omit"],
  ]);
});

it("compresses the offer if the browser can, since an uplink may be a modem's", async () => {
  const { headers, body } = await packed({ sdp: "v=0", client: "some-uuid" });
  expect(headers).toMatchObject({ "Content-Encoding": "gzip" });
  const stream = (body as Blob).stream().pipeThrough(new DecompressionStream("gzip"));
  expect(await new Response(stream).text()).toBe(PLAIN.body);
});

it("passes on the server's sentence when the offer is refused", async () => {
  answer(503, '{"error": "All 100 places are taken; try again later."}');
  await expect(postOffer({}, signal)).rejects.toThrow(
    new RequestError(says("All 100 places are taken; try again later."), true),
  );
});

it("shows its own sentence if the answer is not from our server", async () => {
  answer(502, "<html>Bad gateway</html>");
  await expect(postOffer({}, signal)).rejects.toThrow("The server answered 502.");
});

it("says so if nobody answers", async () => {
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  await expect(postOffer({}, signal)).rejects.toThrow("The server cannot be reached.");
});

it("continues without ICE servers if that request is refused, but not without a server", async () => {
  answer(
    200,
    '{"iceServers": [{"urls": "stun:example.org"}], "relayOnly": true, "wantsCandidates": true}',
  );
  const iceServers = [{ urls: "stun:example.org" }];
  expect(await askIce(signal)).toEqual({ iceServers, relayOnly: true, wantsCandidates: true });
  answer(404, "");
  const none = { iceServers: [], relayOnly: false, wantsCandidates: false };
  expect(await askIce(signal)).toEqual(none);
  vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
  await expect(askIce(signal)).rejects.toThrow("The server cannot be reached.");
});

it("passes on the seconds that the server asks to wait, and nothing else", async () => {
  const asked = async (text: string) => {
    const headers = { "Retry-After": text };
    vi.stubGlobal("fetch", async () => new Response("{}", { status: 503, headers }));
    return postOffer({}, signal).catch((error: RequestError) => error.retryAfterMs);
  };
  expect(await asked("12")).toBe(12_000);
  expect(await asked("soon")).toBeNull();
  expect(await asked("-1")).toBeNull();
});

it.each([
  ["", 2000],
  ["candidate:1 1 udp 1 203.0.113.2 9 typ srflx", 2000],
  ["candidate:1 1 udp 1 203.0.113.9 9 typ relay", 200],
])("waits for candidates no longer than any can take to come (%s)", async (candidate, ms) => {
  vi.useFakeTimers();
  const pc = Object.assign(new EventTarget(), { iceGatheringState: "gathering" });
  let isReady = false;
  void gathered(pc as unknown as RTCPeerConnection).then(() => {
    isReady = true;
  });
  pc.dispatchEvent(Object.assign(new Event("icecandidate"), { candidate: { candidate } }));
  await vi.advanceTimersByTimeAsync(ms - 1);
  expect(isReady).toBe(false);
  await vi.advanceTimersByTimeAsync(1);
  expect(isReady).toBe(true);
  vi.useRealTimers();
});
