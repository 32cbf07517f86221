// @vitest-environment happy-dom
import { getByRole, getByText, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import { hello, room, served } from "../testing/messages";
import { testSession } from "../testing/session";
import { SessionContext } from "./context";
import { Stats } from "./Stats";

const { body } = document;
const PAGE = { StatsPage: () => <p>All of them</p> };
const NAME = "Plots, and why it is slow";
const TOO_THIN = /^Details wait until your turn is over/;

let session: Session;
let load: ReturnType<typeof vi.fn<() => Promise<typeof PAGE>>>;

beforeEach(() => {
  session = testSession();
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 1 });
  load = vi.fn(async () => PAGE);
  act(() =>
    render(
      <SessionContext.Provider value={session}>
        <Stats load={load} />
      </SessionContext.Provider>,
      body,
    ),
  );
});

afterEach(() => {
  act(() => render(null, body));
});

const button = () => getByRole<HTMLButtonElement>(body, "button", { name: NAME });

async function press(name = NAME): Promise<void> {
  await act(async () => getByRole(body, "button", { name }).click());
}

function link(bps: number, operator?: number): void {
  act(() => {
    session.state.served.value = served({ link_bps: bps });
    session.state.room.value = room(operator ? { operator } : { watching: [1] });
  });
}

it("loads the details for who asks, once", async () => {
  link(2_000_000);
  expect(load).not.toHaveBeenCalled();
  await press();
  expect(getByText(body, "All of them")).toBeTruthy();
  expect(button().getAttribute("aria-expanded")).toBe("true");
  await press();
  expect(queryByText(body, "All of them")).toBeNull();
  await press();
  expect(getByText(body, "All of them")).toBeTruthy();
  expect(load).toHaveBeenCalledOnce();
});

it("says that it loads, and what to do where that fails", async () => {
  let fail = (_why: Error) => {};
  load.mockImplementationOnce(
    () =>
      new Promise((_, reject) => {
        fail = reject;
      }),
  );
  await press();
  expect(getByRole(body, "status").textContent).toBe("Loading the details…");
  await act(async () => fail(new Error("offline")));
  expect(getByRole(body, "alert").textContent).toContain("could not be loaded");
  await press("Try again");
  expect(getByText(body, "All of them")).toBeTruthy();
});

it("loads nothing while a thin link is driven over, and says so", async () => {
  link(48_000, 1);
  expect(button().disabled).toBe(true);
  expect(getByText(body, TOO_THIN)).toBeTruthy();
  await press();
  expect(load).not.toHaveBeenCalled();
  link(48_000);
  expect(queryByText(body, TOO_THIN)).toBeNull();
  await press();
  expect(load).toHaveBeenCalledOnce();
});

it("opens over a thin link what is there already", async () => {
  link(48_000);
  await press();
  await press();
  link(48_000, 1);
  await press();
  expect(getByText(body, "All of them")).toBeTruthy();
});

it("does not try again by itself where the link became thin meanwhile", async () => {
  load.mockRejectedValueOnce(new Error("offline"));
  await press();
  link(48_000, 1);
  expect(getByRole<HTMLButtonElement>(body, "button", { name: "Try again" }).disabled).toBe(true);
});
