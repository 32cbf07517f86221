// @vitest-environment dom
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { watchNetwork } from "./network";

let ending: AbortController;
let changed: ReturnType<typeof vi.fn<() => void>>;

beforeEach(() => {
  ending = new AbortController();
  changed = vi.fn<() => void>();
});

afterEach(() => {
  ending.abort();
});

/** A browser that reports its network as phones do. */
function connection(type: string) {
  const found = Object.assign(new EventTarget(), { type });
  vi.stubGlobal("navigator", { connection: found });
  watchNetwork(changed, ending.signal);
  return (next: string) => {
    found.type = next;
    found.dispatchEvent(new Event("change"));
  };
}

it("reports that there is a network again", () => {
  watchNetwork(changed, ending.signal);
  window.dispatchEvent(new Event("online"));
  expect(changed).toHaveBeenCalledOnce();
  ending.abort();
  window.dispatchEvent(new Event("online"));
  expect(changed).toHaveBeenCalledOnce();
});

it("reports another network, but not its absence or another speed", () => {
  const change = connection("wifi");
  change("wifi");
  expect(changed).not.toHaveBeenCalled();
  change("none");
  expect(changed).not.toHaveBeenCalled();
  change("cellular");
  expect(changed).toHaveBeenCalledOnce();
});
