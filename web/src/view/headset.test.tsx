// @vitest-environment dom
import { getByRole, queryByRole } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { draw, undraw } from "../testing/draw";
import { testSession } from "../testing/session";
import { Headset } from "./Headset";

const { body } = document;
let isThere: boolean;
let xr: EventTarget;
const requestSession = vi.fn<() => Promise<XRSession>>();

beforeEach(() => {
  isThere = true;
  requestSession.mockReset().mockRejectedValue(new DOMException("no", "NotAllowedError"));
  const isSessionSupported = async (mode: string) => isThere && mode === "immersive-vr";
  xr = Object.assign(new EventTarget(), { isSessionSupported, requestSession });
  Object.defineProperty(navigator, "xr", { value: xr, configurable: true });
});

afterEach(() => {
  undraw();
  Reflect.deleteProperty(navigator, "xr");
});

const settle = () =>
  act(async () => {
    await vi.dynamicImportSettled();
    await new Promise<void>((done) => setTimeout(done));
  });
const button = () => queryByRole(body, "button", { name: "Headset" });

/** One that starts, but for these. */
function session(more: Partial<XRSession> = {}): XRSession {
  const requestReferenceSpace = async () => ({});
  const rest = { requestReferenceSpace, updateRenderState: vi.fn(), end: vi.fn(async () => {}) };
  return Object.assign(new EventTarget(), rest, more) as unknown as XRSession;
}

async function show(): Promise<void> {
  draw(testSession(), <Headset />);
  await settle();
}

it("is offered only where the browser has a headset", async () => {
  isThere = false;
  await show();
  expect(button()).toBeNull();
  isThere = true;
  xr.dispatchEvent(new Event("devicechange"));
  await settle();
  expect(button()).not.toBeNull();
});

it("is not offered by a browser without WebXR", async () => {
  Reflect.deleteProperty(navigator, "xr");
  await show();
  expect(button()).toBeNull();
});

it("says what to do when the browser does not let the page in", async () => {
  await show();
  act(() => button()?.click());
  await settle();
  expect(requestSession).toHaveBeenCalledWith("immersive-vr");
  expect(getByRole(body, "alert").textContent).toMatch(/^The headset has not started\./);
});

it("says the same while the browser does not answer", async () => {
  await show();
  vi.useFakeTimers();
  requestSession.mockReturnValue(new Promise(() => {}));
  act(() => button()?.click());
  expect(queryByRole(body, "alert")).toBeNull();
  act(() => void vi.advanceTimersByTime(4000));
  expect(getByRole(body, "alert").textContent).toMatch(/^The headset has not started\./);
  vi.useRealTimers();
});

it("leaves a session that it cannot draw", async () => {
  const { end } = session();
  requestSession.mockResolvedValue(session({ end }));
  await show();
  act(() => button()?.click());
  await settle();
  expect(end).toHaveBeenCalled();
  expect(queryByRole(body, "alert")).not.toBeNull();
});
