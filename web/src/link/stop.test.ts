import { beforeEach, expect, it, vi } from "vitest";
import { says } from "../words/said";
import { postRelease, postStop } from "./stop";

const fetching = vi.fn();

beforeEach(() => {
  fetching.mockReset();
  vi.stubGlobal("fetch", fetching);
});

it("posts a stop in the same task, ahead of other requests, even if the page closes", async () => {
  fetching.mockResolvedValue(new Response('{"stop": 7}'));
  const posted = postStop("some-uuid", 5);
  expect(fetching).toHaveBeenCalledWith(
    "api/stop",
    expect.objectContaining({
      method: "POST",
      body: '{"client":"some-uuid","press":5}',
      keepalive: true,
      priority: "high",
    }),
  );
  expect(await posted).toBe(7);
});

it("sends the tab's secret, which identifies a browser without cookies", () => {
  fetching.mockResolvedValue(new Response('{"stop": 7}'));
  void postStop("some-uuid", 5);
  const [, { headers }] = fetching.mock.lastCall as [string, { headers: object }];
  expect(headers).toEqual({ "Content-Type": "application/json", "WAX-Tab": "some-uuid" });
});

it("rejects an answer without a stop", async () => {
  fetching.mockResolvedValue(new Response('{"ok": true}'));
  await expect(postStop("c", 5)).rejects.toMatchObject({ isFinal: false });
});

it("distinguishes a refusal from no answer", async () => {
  fetching.mockResolvedValue(new Response('{"error": "Only whoever drives."}', { status: 403 }));
  await expect(postStop("c", 5)).rejects.toMatchObject({
    saying: says("Only whoever drives."),
    isRefusal: true,
    isFinal: true,
  });
  fetching.mockRejectedValue(new TypeError("Failed to fetch"));
  await expect(postStop("c", 5)).rejects.toMatchObject({ isRefusal: false });
});

it("posts the number of the released stop", async () => {
  fetching.mockResolvedValue(new Response('{"ok": true}'));
  await postRelease("some-uuid", 7);
  expect(fetching).toHaveBeenCalledWith(
    "api/release",
    expect.objectContaining({ body: '{"client":"some-uuid","stop":7}' }),
  );
});
