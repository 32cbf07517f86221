// @vitest-environment dom
import { findByText, getByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, expect, it, vi } from "vitest";
import { draw, undraw } from "../testing/draw";
import { testSession } from "../testing/session";
import { Stats } from "./Stats";

vi.mock("../stats/StatsPage", () => ({ StatsPage: () => <p>All of them</p> }));

const { body } = document;

afterEach(undraw);

it("opens and closes the details", async () => {
  draw(testSession(), <Stats />);
  const button = getByRole(body, "button", { name: "Plots, and why it is slow" });
  const press = () => act(async () => button.click());
  expect(queryByText(body, "All of them")).toBeNull();
  await press();
  expect(await findByText(body, "All of them")).toBeTruthy();
  expect(button.getAttribute("aria-expanded")).toBe("true");
  await press();
  expect(queryByText(body, "All of them")).toBeNull();
});
