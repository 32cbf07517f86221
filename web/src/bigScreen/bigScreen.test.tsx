// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import { openView, viewOf } from "../openView";
import { undraw } from "../testing/draw";
import { hello, pressedBy, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { says } from "../words/said";
import { BigScreen } from "./BigScreen";
import { keepRunning } from "./unattended";

const { body } = document;
let session: Session;

function at(address: string): void {
  vi.stubGlobal("location", new URL(address));
}

beforeEach(() => {
  vi.useFakeTimers();
  at("https://robot.example.org/?view=big-screen");
  session = testSession();
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 9 });
  session.state.serverMs.value = 18_000;
});

afterEach(undraw);

function open(): void {
  act(() => render(<BigScreen session={session} />, body));
}

function show(options: Parameters<typeof room>[0]): void {
  act(() => {
    session.state.room.value = room(options);
  });
}

it("shows who drives and for how long, who is next, and how many watch", () => {
  open();
  show({ operator: 1, waiting: [2, 3], watching: [4, 9], endsMs: 60_000 });
  expect(getByText(body, "Ada is driving")).toBeTruthy();
  expect(getByRole(body, "timer", { name: "Time left" }).textContent).toBe("0:42");
  expect(getByText(body, "Next: Bob")).toBeTruthy();
  expect(getByText(body, "3 people watch")).toBeTruthy();
  show({ watching: [9], stop: pressedBy("Cleo") });
  expect(getByText(body, "Nobody is driving: the robot is free")).toBeTruthy();
  expect(queryByRole(body, "timer")).toBeNull();
  expect(getByText(body, "Nobody is waiting")).toBeTruthy();
  expect(queryByText(body, /watch/)).toBeNull();
  expect(getByText(body, "Stopped by Cleo")).toBeTruthy();
});

it("shows a QR code with the page's own address", () => {
  open();
  const address = "https://robot.example.org/";
  const code = getByRole(body, "img", { name: `QR code with the address ${address}` });
  expect(code.querySelector("path")?.getAttribute("d")).toMatch(/^M/);
  expect(code.outerHTML).not.toContain("style");
  expect(getByText(body, address)).toBeTruthy();
  expect(getByText(body, "Scan to drive")).toBeTruthy();
});

it("says so if no phone could open its address", () => {
  at("http://localhost:8080/?view=big-screen");
  open();
  expect(queryByRole(body, "img")).toBeNull();
  expect(getByText(body, /works on this computer only/)).toBeTruthy();
});

it("says why the picture is not live", () => {
  open();
  const problem = () => getByRole(body, "status").textContent;
  expect(problem()).toBe("");
  act(() => {
    session.state.link.value = { is: "waiting", retryAtMs: 0, reason: says("gone") };
  });
  expect(problem()).toContain("tries again by itself");
  act(() => {
    session.state.ended.value = {
      type: "ended",
      text: says("Closed for today."),
      openings: [],
    };
  });
  expect(problem()).toBe("Closed for today.");
});

it("hides its pointer and Stop until somebody moves, and again 3 s later", () => {
  open();
  const isIdle = () => getByRole(body, "main").classList.contains("is-idle");
  expect(isIdle()).toBe(true);
  act(() => void window.dispatchEvent(new Event("pointermove")));
  expect(isIdle()).toBe(false);
  act(() => void vi.advanceTimersByTime(2900));
  expect(isIdle()).toBe(false);
  act(() => void vi.advanceTimersByTime(200));
  expect(isIdle()).toBe(true);
});

it("shows the fate of a Stop that was pressed here", () => {
  open();
  act(() => {
    session.state.isStopUnconfirmed.value = true;
    session.state.notice.value = { text: says("Too many Stops.") };
  });
  expect(getByRole(body, "alert").textContent).toContain("Stop is not confirmed");
  expect(getByText(body, "Too many Stops.")).toBeTruthy();
});

it("has no control but Stop", () => {
  open();
  show({ watching: [9] });
  expect([...body.querySelectorAll("button, input, select, a")]).toEqual([
    getByRole(body, "button", { name: "Stop" }),
  ]);
});

it("has sound only if the address asks for it, after a touch if the browser demands one", () => {
  open();
  expect(session.actions.setSound).not.toHaveBeenCalled();
  undraw();
  at("https://robot.example.org/?view=big-screen&sound=on");
  open();
  expect(session.actions.setSound).toHaveBeenCalledExactlyOnceWith(true);
  expect(getByText(body, "Touch the screen once for sound.")).toBeTruthy();
  act(() => void window.dispatchEvent(new Event("pointerdown")));
  expect(session.actions.setSound).toHaveBeenCalledTimes(2);
  act(() => void body.querySelector("audio")?.dispatchEvent(new Event("playing")));
  expect(queryByText(body, "Touch the screen once for sound.")).toBeNull();
  act(() => void window.dispatchEvent(new Event("pointerdown")));
  expect(session.actions.setSound).toHaveBeenCalledTimes(2);
});

it("only watches: gives back a place that was kept for the user", () => {
  const end = keepRunning(session, { reload: vi.fn() });
  session.state.room.value = room({ watching: [9] });
  expect(session.actions.leave).not.toHaveBeenCalled();
  session.state.room.value = room({ waiting: [9] });
  expect(session.actions.leave).toHaveBeenCalledOnce();
  end();
});

it("shows the picture whatever was chosen in this browser before", () => {
  session.state.preferences.value = { ...session.state.preferences.peek(), picture: false };
  const end = keepRunning(session, { reload: vi.fn() });
  expect(session.actions.setPicture).toHaveBeenCalledWith(true);
  end();
});

it("reconnects whenever it was sent away", () => {
  const end = keepRunning(session, { reload: vi.fn() });
  for (let i = 1; i <= 3; i++) {
    session.state.ended.value = { type: "ended", text: says("Full."), openings: [] };
    vi.advanceTimersByTime(60_000);
    expect(session.actions.comeBack).toHaveBeenCalledTimes(i);
    session.state.ended.value = null;
    vi.advanceTimersByTime(120_000);
  }
  expect(session.actions.comeBack).toHaveBeenCalledTimes(3);
  end();
});

it("reloads when the server has another version", () => {
  const reload = vi.fn();
  const end = keepRunning(session, { reload });
  session.state.hello.value = hello({ version: "0.0.0" });
  session.state.hello.value = null;
  expect(reload).not.toHaveBeenCalled();
  session.state.hello.value = hello({ version: "0.0.1" });
  expect(reload).toHaveBeenCalledOnce();
  end();
});

it("opens by its address, and retries if it could not be loaded", async () => {
  const asked = ["?view=big-screen&sound=on", "?view=stage", "?view=embed", "?view=x", ""];
  expect(asked.map((one) => viewOf(one) !== null)).toEqual([true, true, false, false, false]);
  const reload = vi.fn();
  vi.stubGlobal("location", { ...window.location, reload });
  await openView(body, session, () => Promise.reject(new Error("offline")));
  expect(getByRole(body, "alert").textContent).toContain("tries again by itself");
  vi.advanceTimersByTime(10_000);
  expect(reload).toHaveBeenCalledOnce();
  at("https://robot.example.org/?view=big-screen");
  await act(() => openView(body, session, async () => ({ View: BigScreen })));
  expect(getByRole(body, "heading", { name: "WAX" })).toBeTruthy();
});
