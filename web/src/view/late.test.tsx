// @vitest-environment happy-dom
import { findByRole, findByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, it, vi } from "vitest";
import { late } from "./late";

const body = document.body;

afterEach(() => act(() => render(null, body)));

it("is loaded where it is shown, once, and said where that fails; shown again, it is tried again", async () => {
  const importPart = vi
    .fn<() => Promise<(props: { name: string }) => preact.VNode>>()
    .mockRejectedValueOnce(new Error("no network"))
    .mockResolvedValue(({ name }) => <p>{name}</p>);
  const Part = late(importPart);
  expect(importPart).not.toHaveBeenCalled();
  await act(async () => render(<Part name="Ada" />, body));
  expect((await findByRole(body, "status")).textContent).toContain("could not be loaded");
  await act(async () => render(null, body));
  await act(async () => render(<Part name="Bob" />, body));
  expect(await findByText(body, "Bob")).toBeTruthy();
  await act(async () => render(null, body));
  await act(async () => render(<Part name="Cleo" />, body));
  expect(await findByText(body, "Cleo")).toBeTruthy();
  expect(importPart).toHaveBeenCalledTimes(2);
});
