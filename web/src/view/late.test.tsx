// @vitest-environment dom
import { findByRole, findByText, getByRole, getByText, queryByText } from "@testing-library/dom";
import { type ComponentType, type FunctionComponent, render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import { hello, room, served } from "../testing/messages";
import { testSession } from "../testing/session";
import * as words from "../words/words";
import { SessionContext } from "./context";
import { late } from "./late";

interface Named {
  name: string;
}

const { body } = document;
const WAITS = /^This part of the page loads after your turn/;

let session: Session;
let importPart: ReturnType<typeof vi.fn<() => Promise<FunctionComponent<Named>>>>;

beforeEach(() => {
  session = testSession();
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 1 });
  importPart = vi.fn(async () => ({ name }: Named) => <p>{name}</p>);
});

const hide = () => act(async () => render(null, body));

afterEach(hide);

const show = (Part: ComponentType<Named>, name = "Ada") =>
  act(async () =>
    render(
      <SessionContext.Provider value={session}>
        <Part name={name} />
      </SessionContext.Provider>,
      body,
    ),
  );

const link = (bps: number, operator?: number) =>
  act(async () => {
    session.state.served.value = served({ link_bps: bps });
    session.state.room.value = room(operator ? { operator } : { watching: [1] });
  });

it("is loaded once, when first shown", async () => {
  const Part = late(importPart);
  expect(importPart).not.toHaveBeenCalled();
  await show(Part);
  expect(await findByText(body, "Ada")).toBeTruthy();
  await hide();
  await show(Part, "Bob");
  expect(await findByText(body, "Bob")).toBeTruthy();
  expect(importPart).toHaveBeenCalledOnce();
});

it("says that it is loading, and what to do if that fails", async () => {
  let fail = (_why: Error) => {};
  importPart.mockImplementationOnce(
    () =>
      new Promise((_, reject) => {
        fail = reject;
      }),
  );
  await show(late(importPart));
  expect(getByRole(body, "status").textContent).toBe("Loading…");
  await act(async () => fail(new Error("no network")));
  expect((await findByRole(body, "alert")).textContent).toContain("could not be loaded");
  await act(async () => getByRole(body, "button", { name: "Try again" }).click());
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("is retried when it is shown again", async () => {
  importPart.mockRejectedValueOnce(new Error("no network"));
  const Part = late(importPart);
  await show(Part);
  await hide();
  await show(Part);
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("waits while driving needs a thin link, says so, and loads after the turn", async () => {
  await link(48_000, 1);
  await show(late(importPart));
  expect(getByText(body, WAITS)).toBeTruthy();
  expect(importPart).not.toHaveBeenCalled();
  await link(48_000);
  expect(queryByText(body, WAITS)).toBeNull();
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("is shown over a thin link if it is loaded already", async () => {
  const Part = late(importPart);
  await show(Part);
  await hide();
  await link(48_000, 1);
  await show(Part);
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("is loaded over a thin link if driving itself needs it", async () => {
  await link(48_000, 1);
  await show(late(importPart, { isForDriving: true }));
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("shows nothing over the picture while it loads or if that fails", async () => {
  importPart.mockRejectedValueOnce(new Error("no network"));
  const Part = late(importPart, { isForDriving: true, isOverPicture: true });
  await show(Part);
  expect(importPart).toHaveBeenCalledOnce();
  expect(body.textContent).toBe("");
  await hide();
  await show(Part);
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("waits also after a failure if the link became thin meanwhile", async () => {
  importPart.mockRejectedValueOnce(new Error("no network"));
  await show(late(importPart));
  await link(48_000, 1);
  expect(getByText(body, WAITS)).toBeTruthy();
  expect(importPart).toHaveBeenCalledOnce();
  await link(48_000);
  expect(await findByText(body, "Ada")).toBeTruthy();
});

it("loads the words that the first load lacks, except for driving", async () => {
  const loadLaterEnglish = vi.spyOn(words, "loadLaterEnglish");
  await show(late(importPart, { isForDriving: true }));
  expect(loadLaterEnglish).not.toHaveBeenCalled();
  await show(late(importPart));
  expect(loadLaterEnglish).toHaveBeenCalledOnce();
});
