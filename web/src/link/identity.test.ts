import { expect, it, vi } from "vitest";
import { Identity } from "./identity";

function storage(content: Record<string, string> = {}) {
  return {
    getItem: (key: string) => content[key] ?? null,
    setItem: (key: string, value: string) => {
      content[key] = value;
    },
  };
}

/** Channels that deliver at once what BroadcastChannel delivers a little later. */
function channels(count: number): BroadcastChannel[] {
  const all: { onmessage: ((event: { data: unknown }) => void) | null }[] = [];
  for (let i = 0; i < count; i++) {
    const one = {
      onmessage: null,
      postMessage: (data: unknown) => {
        for (const other of all) if (other !== one) other.onmessage?.({ data });
      },
    };
    all.push(one);
  }
  return all as unknown as BroadcastChannel[];
}

it("is a random UUID that survives a reload", () => {
  const tab = storage();
  const { client } = new Identity(tab);
  expect(client).toMatch(/^[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/);
  expect(new Identity(tab).client).toBe(client);
  expect(new Identity(storage()).client).not.toBe(client);
});

it("works without a storage", () => {
  expect(new Identity(null).client).toMatch(/^[0-9a-f-]{36}$/);
});

it("lets the first page keep its identity when the tab is duplicated", () => {
  const [a, b] = channels(2) as [BroadcastChannel, BroadcastChannel];
  const content = { "wax-client": "11111111-1111-4111-8111-111111111111" };
  const first = new Identity(storage({ ...content }));
  const second = new Identity(storage({ ...content }));
  const renewed = [vi.fn(), vi.fn()] as const;
  first.share(a, renewed[0]);
  second.share(b, renewed[1]);
  expect(first.client).toBe(content["wax-client"]);
  expect(second.client).not.toBe(first.client);
  expect(renewed[0]).not.toHaveBeenCalled();
  expect(renewed[1]).toHaveBeenCalledOnce();
});

it("ignores pages with identities of their own", () => {
  const [a, b] = channels(2) as [BroadcastChannel, BroadcastChannel];
  const renewed = vi.fn();
  new Identity(storage()).share(a, renewed);
  new Identity(storage()).share(b, renewed);
  expect(renewed).not.toHaveBeenCalled();
});
