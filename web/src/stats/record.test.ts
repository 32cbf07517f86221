import { beforeEach, expect, it } from "vitest";
import { loadPreferences } from "../preferences";
import { createState, type Facts, type State } from "../state";
import { hello, playout, pressedBy, room, served, viewer } from "../testing/messages";
import { says } from "../words/said";
import type { History } from "./history";
import { recordHistory, unnamed } from "./record";

let state: State;
let history: History;
let nowMs: number;

beforeEach(() => {
  nowMs = 1000;
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: 1 });
  state.size.value = "480x360";
  history = recordHistory(state, () => nowMs);
});

function measure(more: Partial<Facts> = {}): void {
  state.facts.value = { ...state.facts.peek(), ...more };
}

const marks = () => history.marks.map((one) => `${one.kind}: ${one.text}`);

it("records each measurement with what was served then", () => {
  expect(history.length).toBe(0);
  state.served.value = served({ rendition: "320x240 at 100 kbit/s", link_bps: 200_000 });
  state.playout.value = playout({ picture_target_ms: 60 });
  measure({ pictureMs: 80, jitterMs: 4, fps: 14, arrivedFps: 15 });
  nowMs = 2000;
  measure({ pictureMs: 90 });
  expect(history.times()).toEqual([1000, 2000]);
  expect(history.column("pictureMs")).toEqual([80, 90]);
  expect(history.column("widthPx")).toEqual([320, 320]);
  expect(history.column("askedPx")).toEqual([480, 480]);
  expect(history.column("linkBps")).toEqual([200_000, 200_000]);
  expect(history.column("heldMs")).toEqual([60, 60]);
  expect(history.column("shownHz")).toEqual([14, 14]);
});

it("distinguishes a picture that is not sent from an unknown one", () => {
  measure();
  nowMs = 2000;
  state.served.value = served({ rendition: null });
  state.preferences.value = { ...state.preferences.peek(), picture: false };
  measure();
  expect(history.column("widthPx")).toEqual([null, 0]);
  expect(history.column("sentHz")).toEqual([null, 0]);
  expect(history.column("askedPx")).toEqual([480, 0]);
});

it("marks each event once, and nothing before it happens", () => {
  expect(marks()).toEqual([]);
  state.link.value = { is: "connected" };
  state.room.value = room({
    operator: 1,
    number: 4,
    stop: pressedBy("Bob", { number: 2 }),
  });
  state.room.value = room({ operator: 1, number: 4 });
  state.driveReason.value = says("Slow: the picture is late.");
  state.driveReason.value = null;
  state.served.value = served({ reason: says("The link is full.") });
  state.served.value = served({ reason: says("The link is full."), link_bps: 1 });
  state.playout.value = playout();
  state.player.value = { by: "built-in", why: null };
  state.room.value = room({ operator: 2, number: 5 });
  state.room.value = room({});
  expect(marks()).toEqual([
    "link: Connected",
    "turn: Your turn begins",
    "stop: Stop is pressed",
    "stop: Stop is released",
    "robot: Slow: the picture is late.",
    "sent: 640 × 480 at 500 kbit/s: The link is full.",
    "policy: Smooth: the picture follows the sound",
    "player: WAX's own player plays the sound",
    "turn: Somebody else's turn begins",
    "turn: Nobody drives",
  ]);
});

it("records nobody's name", () => {
  const present = room({
    stop: pressedBy("Ada from elsewhere", { number: 2 }),
  });
  state.room.value = { ...present, viewers: [viewer(1, { name: "Ada" }), viewer(2, { name: "" })] };
  state.driveReason.value = says("Stopped by Ada. Release the stop, then drive again.");
  expect(marks().at(-1)).toBe("robot: Stopped by …. Release the stop, then drive again.");
  expect(unnamed("By Ada from elsewhere.", state)).toBe("By ….");
});
