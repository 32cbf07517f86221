// @vitest-environment dom
import { afterEach, beforeEach, expect, it } from "vitest";
import { keepFocus, returnFocusAfterPointer } from "./focus";
import { eventually } from "./testing/eventually";

let aborting: AbortController;

beforeEach(() => {
  aborting = new AbortController();
  returnFocusAfterPointer(document, aborting.signal);
});

afterEach(() => {
  aborting.abort();
  document.body.replaceChildren();
});

function operate(html: string, by: "pointerdown" | "keydown", then: "click" | "change"): boolean {
  document.body.innerHTML = html;
  const control = document.body.firstElementChild as HTMLElement;
  control.dispatchEvent(new Event(by, { bubbles: true }));
  control.focus();
  control.dispatchEvent(new Event(then, { bubbles: true }));
  return document.activeElement === control;
}

it.each([
  ["<button>Sound</button>", "click"],
  ["<input type='radio'>", "change"],
  ["<input type='range'>", "change"],
  ["<select></select>", "change"],
] as const)("takes the focus from %s after a pointer, not after a key", (html, then) => {
  expect(operate(html, "pointerdown", then)).toBe(false);
  expect(operate(html, "keydown", then)).toBe(true);
});

it("keeps a select's list open after the click that opened it", () => {
  expect(operate("<select></select>", "pointerdown", "click")).toBe(true);
});

it("leaves the focus in a text field that was clicked", () => {
  expect(operate("<input type='text'>", "pointerdown", "click")).toBe(true);
});

it.each([
  ["a section that stays", "<section><p><button>Join</button></p></section>", "button", "section"],
  [
    "what follows a section that goes",
    "<div><section><button>Got it</button></section><section id='b'></section></div>",
    "section",
    "#b",
  ],
])("lands the keyboard on %s", async (_where, html, goes, landing) => {
  keepFocus(document, aborting.signal);
  document.body.innerHTML = html;
  const control = document.querySelector("button") as HTMLElement;
  control.dispatchEvent(new Event("keydown", { bubbles: true }));
  control.focus();
  document.querySelector(goes)?.remove();
  await eventually(() => expect(document.activeElement).toBe(document.querySelector(landing)));
  expect(document.activeElement?.getAttribute("tabindex")).toBe("-1");
});

it("moves the focus nowhere after a pointer", async () => {
  keepFocus(document, aborting.signal);
  document.body.innerHTML = "<section><button>Join</button></section>";
  const control = document.querySelector("button") as HTMLElement;
  control.dispatchEvent(new Event("pointerdown", { bubbles: true }));
  control.focus();
  control.remove();
  await new Promise((resolve) => setTimeout(resolve, 20));
  expect(document.activeElement).toBe(document.body);
});
