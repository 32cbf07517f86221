// @vitest-environment dom
import { beforeEach, expect, it, vi } from "vitest";
import { clickDespiteShift } from "./layoutShift";

const clicked = vi.fn<(name: string) => void>();

beforeEach(() => {
  const aborting = new AbortController();
  document.body.innerHTML = "<ul><li><button>ban</button></li><li><button>mute</button></li></ul>";
  for (const button of document.querySelectorAll("button")) {
    const press = ({ detail }: MouseEvent) => detail === 1 && clicked(button.textContent ?? "");
    button.addEventListener("click", press);
  }
  clickDespiteShift(document, aborting.signal);
  return () => {
    aborting.abort();
    clicked.mockReset();
  };
});

/** Presses `ban`, and lets go at `dx`, where the browser says that `over` was clicked. */
function press(over: string, dx: number): void {
  const at = (clientX: number) => ({ bubbles: true, clientX, clientY: 50, detail: 1 });
  document.querySelector("button")?.dispatchEvent(new PointerEvent("pointerdown", at(50)));
  document.querySelector(over)?.dispatchEvent(new MouseEvent("click", at(50 + dx)));
}

it.each([
  ["the page moved under it", "ul", 3, ["ban"]],
  ["nothing moved", "button", 0, ["ban"]],
  ["the pointer was taken away", "ul", 40, []],
  ["something else was clicked", "li + li button", 0, ["mute"]],
])("a press counts for what it began on: %s", (_, over, dx, expected) => {
  press(over, dx);
  expect(clicked.mock.calls.flat()).toEqual(expected);
});
