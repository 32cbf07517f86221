// @vitest-environment dom
import { beforeEach, expect, it } from "vitest";
import { alertTab } from "./tabIcon";

beforeEach(() => {
  document.head.innerHTML = '<link rel="icon" href="icon.svg">';
});

it("shows another icon while the user is wanted, then the usual one", () => {
  const icon = () => document.querySelector("link")?.getAttribute("href");
  alertTab(document, true);
  expect(icon()).toBe("icon-wanted.svg");
  alertTab(document, false);
  expect(icon()).toBe("icon.svg");
});
