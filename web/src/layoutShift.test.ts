// @vitest-environment dom
import { beforeEach, expect, it, vi } from "vitest";
import { clickDespiteShift } from "./layoutShift";

const clicked = vi.fn<(name: string) => void>();

beforeEach(() => {
  const aborting = new AbortController();
  document.body.innerHTML = "<ul><li><button>ban</button></li><li><button>mute</button></li></ul>";
  for (const one of document.querySelectorAll("ul, button")) {
    const name = one.matches("ul") ? "list" : one.textContent;
    one.addEventListener("click", (event) => event.target === one && clicked(name));
  }
  clickDespiteShift(document, aborting.signal);
  return () => {
    aborting.abort();
    clicked.mockReset();
  };
});

const BAN = "li button";
const MUTE = "li + li button";

it.each([
  ["nothing moved", { now: BAN, over: BAN }, ["ban"]],
  ["the page moved under a mouse", { now: "ul", over: "ul" }, ["ban"]],
  ["it moved another one under a finger", { now: MUTE, over: MUTE }, ["ban"]],
  ["the pointer slipped off", { now: BAN, over: "ul" }, ["list"]],
  ["the pointer was taken away", { now: "ul", over: MUTE, dx: 40 }, ["mute"]],
  ["a key clicked", { now: "ul", over: MUTE, detail: 0 }, ["mute"]],
  ["it may not be pressed", { now: "ul", over: "ul", disabled: true }, ["list"]],
])("a press counts for what it began on: %s", (_, { now, over, ...rest }, expected) => {
  const { dx, detail, disabled } = { dx: 3, detail: 1, disabled: false, ...rest };
  const find = (what: string) => document.querySelector<HTMLElement>(what);
  document.elementFromPoint = () => find(now);
  find(BAN)?.toggleAttribute("disabled", disabled);
  const at = { bubbles: true, cancelable: true, clientY: 50 };
  find(BAN)?.dispatchEvent(new PointerEvent("pointerdown", { ...at, clientX: 50 }));
  find(over)?.dispatchEvent(new MouseEvent("click", { ...at, clientX: 50 + dx, detail }));
  expect(clicked.mock.calls.flat()).toEqual(expected);
});
