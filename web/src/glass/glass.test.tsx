// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import { DEFAULTS } from "../generated/defaults";
import { viewOf } from "../openView";
import { undraw } from "../testing/draw";
import { hello, room } from "../testing/messages";
import { testSession } from "../testing/session";
import type { Sight } from "./delays";
import { Glass } from "./Glass";
import { type Problem, watchCode } from "./watch";

vi.mock(import("./watch"), () => ({ watchCode: vi.fn(() => () => {}) }));

const { body } = document;
let session: Session;
let tell: (what: Sight | Problem) => void;

function open(address: string, isHost = false): void {
  vi.stubGlobal("location", new URL(address, "https://robot.example.org/"));
  const { link, hello: greeting } = session.state;
  link.value = { is: "connected" };
  greeting.value = hello({ viewer: 9, is_host: isHost });
  act(() => render(<Glass session={session} />, body));
  tell = (what) => act(() => vi.mocked(watchCode).mock.lastCall?.[2](what));
}

/** Tells the page what the host has kept. */
function keeps(camera_delay_ms: number | null): void {
  const host_settings = { ...DEFAULTS.HostSettings(), camera_delay_ms };
  act(() => {
    session.state.room.value = { ...room({ watching: [9] }), host_settings };
  });
}

const told = (name: string) => getByText(body, name).nextElementSibling?.textContent;

beforeEach(() => {
  vi.useFakeTimers({ now: 0 });
  session = testSession();
});

afterEach(() => {
  undraw();
  vi.useRealTimers();
});

it("says the delay, WAX's part of it, and what is left", () => {
  open("?view=glass");
  act(() => {
    const { facts } = session.state;
    facts.value = { ...facts.value, pictureMs: 92.4, pictureErrorMs: 1.2 };
  });
  expect(told("Camera to screen")).toBe("–");
  for (let n = 0; n < 20; n++) tell({ totalMs: 140 + n, knownMs: 92 });
  expect(told("Camera to screen")).toBe("149 ms");
  expect(told("95 % are below")).toBe("158 ms");
  expect(told("Pictures read")).toBe("20");
  expect(told("WAX: capture to display")).toBe("92 ms ± 2");
  expect(told("Camera, exposure and screen")).toBe("57 ms");
});

it("says what to change once no picture was read for a while", () => {
  open("?view=glass");
  const hint = () => getByRole(body, "status").textContent;
  tell("dark");
  expect(hint()).toBe("");
  vi.advanceTimersByTime(2000);
  tell("dark");
  expect(hint()).toContain("too dark");
  tell({ totalMs: 140, knownMs: null });
  expect(hint()).toBe("");
  act(() => {
    session.state.link.value = { is: "connecting", reason: null };
  });
  expect(hint()).toContain("Connecting");
});

it("lets the host alone keep the rest, once 30 pictures say so", () => {
  open("?view=glass");
  for (let n = 0; n < 30; n++) tell({ totalMs: 140, knownMs: 92.3 });
  expect(queryByRole(body, "button")).toBeNull();
  undraw();
  open("?view=glass", true);
  for (let n = 0; n < 29; n++) tell({ totalMs: 140, knownMs: 92.3 });
  expect(queryByRole(body, "button")).toBeNull();
  tell({ totalMs: 140, knownMs: 92.3 });
  act(() => getByRole(body, "button", { name: "Keep 48 ms for Details" }).click());
  const { actAsHost } = session.actions;
  expect(actAsHost).toHaveBeenLastCalledWith({ type: "keep_camera_delay", delay_ms: 48 });
  expect(queryByText(body, /Details adds/)).toBeNull();
  keeps(48);
  expect(getByText(body, /Details adds 48 ms/)).toBeTruthy();
  act(() => getByRole(body, "button", { name: "Forget it" }).click());
  expect(actAsHost).toHaveBeenLastCalledWith({ type: "keep_camera_delay", delay_ms: null });
});

it("shows nothing but the code on another screen, whose address it says", async () => {
  open("?view=glass");
  const link = getByRole<HTMLAnchorElement>(body, "link");
  expect(link.getAttribute("href")).toBe("https://robot.example.org/?view=glass&only=code");
  undraw();
  open(link.href);
  expect([...body.querySelectorAll("main > *")]).toEqual([getByRole(body, "img")]);
  expect(session.attachPicture).toHaveBeenLastCalledWith(null);
  expect(await viewOf("?view=glass")?.()).toHaveProperty("View", Glass);
});

it("says that a browser cannot tell when it shows a picture", () => {
  vi.mocked(watchCode).mockReturnValueOnce(null);
  open("?view=glass");
  expect(getByRole(body, "status").textContent).toContain("This browser cannot say");
});
