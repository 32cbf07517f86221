// @vitest-environment dom
import { beforeEach, expect, it, vi } from "vitest";
import { Cameras } from "./cameras";
import { listenKey } from "./listenKey";
import { loadPreferences } from "./preferences";
import { createState, type State } from "./state";
import { hello, pressedBy, room, served } from "./testing/messages";
import { type Saying, said, says } from "./words/said";

const TWO = [
  { name: "Door", axes: [] },
  { name: "Above", axes: ["pan"] },
];
let state: State;
let cameras: Cameras;
let nowMs: number;
const send = vi.fn();
const heard = vi.fn();
const say = (what: Saying) => heard(said(what));

beforeEach(() => {
  vi.clearAllMocks();
  nowMs = 10_000;
  vi.spyOn(performance, "now").mockImplementation(() => nowMs);
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: 1, cameras: TWO });
  state.link.value = { is: "connected" };
  state.served.value = served({ cameras: ["small", "small"] });
  cameras = new Cameras({ state, send, say, tellsFrames: true });
  vi.stubGlobal("MediaStream", class {});
  cameras.setTracks([{} as MediaStreamTrack, {} as MediaStreamTrack]);
});

/** Advances time while these cameras show pictures. */
function pass(ms: number, showing: number[]): void {
  const endMs = nowMs + ms;
  while (nowMs < endMs) {
    nowMs += 100;
    for (const at of showing) cameras.presented(at);
    cameras.checkLive(nowMs, false);
  }
}

it("cycles through all cameras and back to the driving view", () => {
  const seen = [0, 1, null].map(() => {
    cameras.next();
    return state.large.value;
  });
  expect(seen).toEqual([0, 1, null]);
  expect(send.mock.calls.map(([look]) => look.large)).toEqual([0, 1, null]);
});

it("sends the server nothing if there are none", () => {
  state.hello.value = hello();
  cameras.next();
  cameras.sendLook();
  expect(send).not.toHaveBeenCalled();
});

it("enlarges the driving view when a turn begins, and allows swapping after that", () => {
  cameras.choose(1);
  state.room.value = room({ operator: 1 });
  expect(state.large.value).toBeNull();
  cameras.choose(1);
  state.room.value = room({
    operator: 1,
    stop: pressedBy("Ada", { number: 3 }),
  });
  expect(state.large.value).toBe(1);
});

it("returns to the driving view with a sentence when the large camera fails", () => {
  cameras.choose(0);
  const failing = [{ problem: says("Door: The camera delivers nothing.") }, { problem: null }];
  cameras.roomChanged({ ...room({}), cameras: failing });
  expect(state.large.value).toBeNull();
  expect(heard).toHaveBeenCalledExactlyOnceWith(
    "Door: The camera delivers nothing. The driving view is large again.",
  );
});

it("keeps the large camera when another fails", () => {
  cameras.choose(1);
  cameras.roomChanged({ ...room({}), cameras: [{ problem: says("gone") }, { problem: null }] });
  expect(state.large.value).toBe(1);
  expect(heard).not.toHaveBeenCalled();
});

it("replaces a large camera that has frozen", () => {
  cameras.choose(0);
  pass(5000, [0, 1]);
  expect(state.large.value).toBe(0);
  pass(2000, [1]);
  expect(state.large.value).toBe(0);
  pass(1000, [1]);
  expect(state.large.value).toBeNull();
  expect([...state.staleCameras.value]).toEqual([0]);
  expect(heard.mock.calls).toEqual([
    ["No new picture comes from Door. The driving view is large again."],
  ]);
});

it("says so when the connection no longer carries the large camera", () => {
  cameras.choose(0);
  state.served.value = served({ cameras: [null, null] });
  pass(4000, []);
  expect(heard.mock.calls).toEqual([
    ["Your connection carries no picture of Door now. The driving view is large again."],
  ]);
});

it.each([
  ["nobody sees", true],
  ["hung", false],
])("a page that %s has shown nothing, which says nothing of the camera", (_, isHidden) => {
  cameras.choose(0);
  pass(200, [0, 1]);
  nowMs += 60_000;
  cameras.presented(1);
  cameras.checkLive(nowMs, isHidden);
  pass(2000, [1]);
  expect(state.large.value).toBe(0);
  pass(1000, [1]);
  expect(state.large.value).toBeNull();
  pass(3000, [0]);
  expect([...state.staleCameras.value]).toEqual([1]);
});

it.each([
  ["the host lets nobody see", { blanked: true }, true],
  ["the picture is off", {}, false],
])("says nothing of a camera while %s", (_, settings, picture) => {
  cameras.choose(0);
  const told = room({});
  state.room.value = { ...told, host_settings: { ...told.host_settings, ...settings } };
  state.preferences.value = { ...state.preferences.value, picture };
  pass(5000, []);
  expect(state.large.value).toBe(0);
  expect(heard).not.toHaveBeenCalled();
});

it.each([
  ["C", "KeyC", "p", {}, 1],
  ["another key", "KeyV", "p", {}, 0],
  ["a shortcut", "KeyC", "p", { ctrlKey: true }, 0],
  ["a name that is typed", "KeyC", "[type=text]", {}, 0],
  ["a key that is held", "KeyC", "p", { repeat: true }, 0],
])("%s swaps or not", (_, code, on, more, times) => {
  document.body.innerHTML = "<input type=text><p></p>";
  const ending = new AbortController();
  const next = vi.fn();
  listenKey(window, next, (code) => code === "KeyC", ending.signal);
  const event = new KeyboardEvent("keydown", { code, bubbles: true, ...more });
  document.querySelector(on)?.dispatchEvent(event);
  ending.abort();
  expect(next).toHaveBeenCalledTimes(times);
});
