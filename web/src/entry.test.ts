import { describe, expect, it, vi } from "vitest";
import { showEntry, takeEntry } from "./entry";
import { said, says } from "./words/said";

/** A window at this fragment, and the calls to its history. */
function at(hash: string) {
  const replaceState = vi.fn();
  const location = { hash, pathname: "/", search: "" };
  const window = { location, history: { replaceState } } as unknown as Window;
  return { window, replaceState };
}

describe("the address", () => {
  it.each(["host", "invite"])("yields the secret of a link for %s, and forgets it", (kind) => {
    const { window, replaceState } = at(`#${kind}=abc_DEF-1=`);
    expect(takeEntry(window)).toEqual({ kind, secret: "abc_DEF-1=" });
    expect(replaceState).toHaveBeenCalledWith(null, "", "/");
  });

  it("forgets an empty one, too", () => {
    const { window, replaceState } = at("#host=");
    expect(takeEntry(window)).toBeNull();
    expect(replaceState).toHaveBeenCalled();
  });

  it.each(["", "#", "#queue", "#hosts=abc"])("is left alone at %j", (hash) => {
    const { window, replaceState } = at(hash);
    expect(takeEntry(window)).toBeNull();
    expect(replaceState).not.toHaveBeenCalled();
  });
});

describe("a secret", () => {
  function answers(status: number, body: object) {
    const fetching = vi.fn(async (_path: string, _init: RequestInit) => {
      return new Response(JSON.stringify(body), { status });
    });
    vi.stubGlobal("fetch", fetching);
    return fetching;
  }

  it("of the host is sent in a body, never in an address", async () => {
    const fetching = answers(200, { ok: true });
    expect((await showEntry({ kind: "host", secret: "s3" })).isGood).toBe(true);
    const [path, init] = fetching.mock.calls[0] ?? [];
    expect([path, init?.body]).toEqual(["api/host", '{"secret":"s3"}']);
  });

  it.each([
    ["queue", "You are invited to drive."],
    ["watch", "You are invited to watch."],
  ])("of an invitation tells for what: %s", async (purpose, words) => {
    const fetching = answers(200, { purpose });
    const { isGood, text } = await showEntry({ kind: "invite", secret: "t" });
    expect([isGood, said(text)]).toEqual([true, words]);
    expect(fetching.mock.calls[0]?.[1].body).toBe('{"token":"t"}');
  });

  it("that is no longer valid shows the server's own words", async () => {
    answers(403, { error: "This invitation is used up; ask the host for a new one." });
    const text = "This invitation is used up; ask the host for a new one.";
    expect(await showEntry({ kind: "invite", secret: "t" })).toEqual({
      isGood: false,
      text: says(text),
    });
  });

  it("that reaches no server says what to do", async () => {
    vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
    const { isGood, text } = await showEntry({ kind: "host", secret: "s" });
    expect(isGood).toBe(false);
    expect(said(text)).toContain("Open the link again");
  });
});
