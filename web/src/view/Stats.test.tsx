// @vitest-environment dom
import { findByText, getByRole, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, it, vi } from "vitest";
import { testSession } from "../testing/session";
import { SessionContext } from "./context";
import { Stats } from "./Stats";

vi.mock("../stats/StatsPage", () => ({ StatsPage: () => <p>All of them</p> }));

const { body } = document;

afterEach(() => {
  act(() => render(null, body));
});

it("opens the details for who asks, and closes them", async () => {
  act(() =>
    render(
      <SessionContext.Provider value={testSession()}>
        <Stats />
      </SessionContext.Provider>,
      body,
    ),
  );
  const button = getByRole(body, "button", { name: "Plots, and why it is slow" });
  const press = () => act(async () => button.click());
  expect(queryByText(body, "All of them")).toBeNull();
  await press();
  expect(await findByText(body, "All of them")).toBeTruthy();
  expect(button.getAttribute("aria-expanded")).toBe("true");
  await press();
  expect(queryByText(body, "All of them")).toBeNull();
});
