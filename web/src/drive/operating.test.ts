// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { ControlInfo, Operate, Sentence } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { aboard, control, hello, pressedBy, room } from "../testing/messages";
import { listenControlKeys } from "./controlKeys";
import { InputState } from "./inputState";
import { Operating } from "./operating";

const ADA = 1;
const BOB = 2;
const CONTROLS: ControlInfo[] = [
  control("horn", { key: "KeyG", roles: ["operator", "host"] }),
  control("lamp", { kind: "toggle", key: "KeyH", roles: ["observer"] }),
  control("dim", { kind: "slider", max: 100 }),
  control("light", { kind: "choice", choices: ["white", "red"] }),
  control("spin", { moves: true }),
  control("lift", { kind: "slider", min: -1, moves: true }),
  ...["a", "b", "c", "d", "e"].map((name) => control(name)),
];

let state: State;
let input: InputState;
let operating: Operating;
let sent: (Operate & { urgent: boolean })[];
let refused: (Sentence | null)[];
let serverMs: number | null;
let aborting: AbortController;

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  refused = [];
  serverMs = 5000;
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: ADA, controls: CONTROLS });
  state.link.value = { is: "connected" };
  const changed = () => operating.inputChanged();
  input = new InputState({ changed, deflected: changed, movesSideways: () => false });
  operating = new Operating({
    state,
    input,
    serverMs: () => serverMs,
    beat: () => "x7-_2A",
    send: (operate, urgent) => sent.push({ ...operate, urgent }),
    refused: (why) => refused.push(why),
  });
  aborting = new AbortController();
  listenControlKeys(window, {
    operating,
    controls: () => state.usableControls.peek(),
    keys: () => state.preferences.peek().keys,
    signal: aborting.signal,
  });
  state.room.value = room({ operator: ADA, number: 7 });
  input.enable();
});

afterEach(() => {
  aborting.abort();
});

const newest = () => sent.at(-1);
const answer = (seq = newest()?.seq ?? -1, why: Sentence | null = null) =>
  operating.answered({ type: "operated", seq, refused: why });

/** How many messages are sent in this time. */
function sentIn(ms: number): number {
  const before = sent.length;
  vi.advanceTimersByTime(ms);
  return sent.length - before;
}

function roomHas(controls: Record<string, number>): void {
  state.room.value = { ...room({ operator: ADA, number: 7 }), controls };
}

describe("a held control", () => {
  it("is sent at once, twenty times a second, and not after its release", () => {
    operating.press("finger", "horn");
    expect(newest()).toEqual({
      type: "operate",
      seq: 0,
      turn: 7,
      sent_server_ms: 5000,
      held: { horn: 1 },
      wanted: {},
      beat: "x7-_2A",
      urgent: false,
    });
    expect(state.heldControls.value).toEqual(new Set(["horn"]));
    expect(sentIn(1000)).toBe(20);
    expect(operating.release("finger")).toBe(true);
    expect(newest()).toMatchObject({ held: {}, urgent: true });
    expect(sentIn(1000)).toBe(2);
    expect(sentIn(1000)).toBe(0);
    expect(operating.release("finger")).toBe(false);
    expect(state.heldControls.value).toEqual(new Set());
  });

  it("stays held while any holder holds it", () => {
    operating.press("finger", "horn");
    operating.press("finger", "spin"); // which holds the horn already
    operating.press("key", "horn");
    operating.release("finger");
    expect(newest()?.held).toEqual({ horn: 1 });
    operating.release("key");
    expect(newest()?.held).toEqual({});
  });

  it("is one of no more than fit into a message", () => {
    for (const name of ["a", "b", "c", "d", "e"]) operating.press(name, name);
    expect(Object.keys(newest()?.held ?? {})).toEqual(["a", "b", "c", "d"]);
  });

  it("counts as driving only if it moves something", () => {
    operating.press("finger", "horn");
    expect(input.isHolding).toBe(false);
    operating.press("other", "spin");
    expect(input.isHolding).toBe(true);
    input.releaseAll();
    expect(newest()?.held).toEqual({ horn: 1 });
  });

  it("cannot start to move while driving is not possible", () => {
    input.disable();
    operating.press("finger", "spin");
    operating.slide("lift", 0.5);
    expect(sent).toEqual([]);
    operating.press("finger", "horn");
    expect(newest()?.held).toEqual({ horn: 1 });
  });

  it("is released after the page hung, since input may have been missed", () => {
    operating.press("finger", "horn");
    const hungMs = performance.now() + 700;
    vi.spyOn(performance, "now").mockImplementation(() => hungMs);
    vi.advanceTimersByTime(50);
    expect(newest()?.held).toEqual({});
    vi.restoreAllMocks();
  });

  it("is not sent while the clocks are not aligned", () => {
    serverMs = null;
    operating.press("finger", "horn");
    expect(sentIn(500)).toBe(0);
    serverMs = 6000;
    expect(sentIn(50)).toBe(1);
  });

  it("is released when refused, and the reason is shown once", () => {
    const why = { code: "control.stopped" };
    operating.press("finger", "spin");
    answer(newest()?.seq, why);
    expect(refused).toEqual([why]);
    expect(newest()?.held).toEqual({});
    expect(input.isHolding).toBe(false);
  });

  it("is released with three messages within one task", () => {
    operating.letGo();
    expect(sent).toEqual([]);
    operating.press("finger", "horn");
    sent = [];
    operating.letGo();
    expect(sent.map(({ held }) => held)).toEqual([{}, {}, {}, {}]);
  });
});

describe("a slider that moves something", () => {
  it("moves once it is slid, and only while it is held", () => {
    operating.press("finger", "lift");
    expect(newest()?.held).toEqual({});
    operating.slide("lift", 0.25);
    expect(newest()?.held).toEqual({ lift: 0.25 });
    operating.slide("lift", 0.5);
    expect(newest()?.held).toEqual({ lift: 0.5 });
    vi.advanceTimersByTime(1000);
    expect(newest()?.held).toEqual({ lift: 0.5 });
    operating.release("finger");
    expect(newest()?.held).toEqual({});
  });

  it("stays held for a moment after each change if no release is reported", () => {
    operating.slide("lift", 0.25);
    vi.advanceTimersByTime(250);
    operating.slide("lift", 0.3);
    vi.advanceTimersByTime(250);
    expect(newest()?.held).toEqual({ lift: 0.3 });
    vi.advanceTimersByTime(100);
    expect(newest()?.held).toEqual({});
    expect(input.isHolding).toBe(false);
  });
});

describe("a set value", () => {
  it("is sent at once, repeated until it has arrived, and shown meanwhile", () => {
    operating.toggle("lamp");
    expect(newest()?.wanted).toEqual({ lamp: 1 });
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
    expect(sentIn(1000)).toBeGreaterThanOrEqual(6);
    expect(sent.every(({ wanted }) => wanted.lamp === 1)).toBe(true);
    answer();
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
    expect(sentIn(1000)).toBe(0);
    roomHas({ lamp: 1 });
    expect(state.wantedControls.value).toEqual({});
    operating.toggle("lamp");
    expect(newest()?.wanted).toEqual({ lamp: 0 });
  });

  it("is shown until it has arrived, whatever the room state says meanwhile", () => {
    operating.toggle("lamp");
    roomHas({ lamp: 1 });
    roomHas({ lamp: 0 });
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
    answer();
    roomHas({ lamp: 0, dim: 3 });
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
  });

  it("arrives although nine of ten messages and answers are lost", () => {
    operating.set("light", 1);
    vi.advanceTimersByTime(1200);
    answer(sent[0]?.seq);
    expect(sentIn(2000)).toBe(0);
    expect(refused).toEqual([]);
  });

  it("is not confirmed by the answer to an earlier value", () => {
    operating.set("dim", 10);
    const first = newest()?.seq;
    vi.advanceTimersByTime(120);
    operating.set("dim", 20);
    answer(first);
    vi.advanceTimersByTime(120);
    expect(newest()?.wanted).toEqual({ dim: 20 });
    answer();
    expect(sentIn(1000)).toBe(0);
  });

  it("is sent with held controls, within the server's rate limit", () => {
    operating.press("finger", "horn");
    for (let value = 0; value < 100; value++) {
      operating.slide("dim", value);
      vi.advanceTimersByTime(10);
    }
    const wishing = sent.filter(({ wanted }) => "dim" in wanted);
    expect(wishing.length).toBeLessThanOrEqual(10);
    expect(sent.every(({ held }) => held.horn === 1)).toBe(true);
    vi.advanceTimersByTime(200);
    expect(sent.findLast(({ wanted }) => "dim" in wanted)?.wanted).toEqual({ dim: 99 });
  });

  it("is sent two at a time", () => {
    operating.set("lamp", 1);
    operating.set("dim", 5);
    operating.set("light", 1);
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ lamp: 1, dim: 5 });
    answer();
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ light: 1 });
  });

  it("is dropped if it does not arrive, with a notice", () => {
    operating.toggle("lamp");
    vi.advanceTimersByTime(3200);
    expect(refused).toEqual([null]);
    expect(state.wantedControls.value).toEqual({});
    expect(sentIn(1000)).toBe(0);
  });

  it("falls back to the room state if it is refused or never confirmed", () => {
    const why = { code: "control.not_yours" };
    operating.toggle("lamp");
    answer(newest()?.seq, why);
    expect(refused).toEqual([why]);
    expect(state.wantedControls.value).toEqual({});
    operating.toggle("lamp");
    answer();
    answer(); // once more, as its first answer seemed lost
    vi.advanceTimersByTime(1700);
    expect(state.wantedControls.value).toEqual({});
    expect(refused).toEqual([why]);
  });

  it("is dropped when a turn ends", () => {
    operating.set("dim", 5);
    state.room.value = room({ operator: BOB, watching: [ADA], number: 8 });
    expect(state.wantedControls.value).toEqual({});
    expect(sentIn(1000)).toBe(0);
  });

  it("ignores answers to unknown messages", () => {
    operating.toggle("lamp");
    answer(99);
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
  });
});

describe("permission", () => {
  const names = () => state.usableControls.value.map(({ name }) => name);

  it("depends on the roles that the host has set", () => {
    expect(names()).toEqual(CONTROLS.map(({ name }) => name));
    state.room.value = room({ operator: BOB, watching: [ADA], number: 8 });
    expect(names()).toEqual(["lamp"]);
    state.hello.value = hello({ viewer: ADA, controls: CONTROLS, is_host: true });
    expect(names()).toEqual(["horn", "lamp"]);
    operating.press("finger", "spin");
    operating.slide("dim", 5);
    operating.set("light", 1);
    expect(sent).toEqual([]);
    operating.press("finger", "horn");
    expect(newest()).toMatchObject({ turn: 0, held: { horn: 1 } });
  });

  it("needs a connection to the robot's server", () => {
    state.isInRoom.value = true;
    expect(names()).toEqual([]);
    state.isInRoom.value = false;
    state.link.value = { is: "connecting", reason: null };
    expect(names()).toEqual([]);
    state.hello.value = null;
    state.link.value = { is: "connected" };
    expect(names()).toEqual([]);
  });

  it("is denied to the operator while the person aboard has the robot", () => {
    state.room.value = { ...room({ operator: ADA, number: 7 }), aboard: aboard({ mode: "hand" }) };
    expect(names()).toEqual(["lamp"]);
    state.room.value = { ...room({ operator: ADA, number: 7 }), aboard: aboard() };
    expect(names()).toContain("spin");
  });
});

describe("a key", () => {
  const press = (type: "keydown" | "keyup", code: string, init: KeyboardEventInit = {}) => {
    const event = new KeyboardEvent(type, { code, bubbles: true, cancelable: true, ...init });
    document.body.dispatchEvent(event);
    return event;
  };

  it("holds a button and flips a toggle", () => {
    expect(press("keydown", "KeyG").defaultPrevented).toBe(true);
    press("keydown", "KeyG", { repeat: true });
    expect(newest()?.held).toEqual({ horn: 1 });
    press("keyup", "KeyG");
    expect(newest()?.held).toEqual({});
    press("keydown", "KeyH");
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ lamp: 1 });
    press("keydown", "KeyH");
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ lamp: 0 });
  });

  it("does nothing if the user has assigned it, or no control has it", () => {
    state.preferences.value = {
      ...state.preferences.value,
      keys: { ...state.preferences.value.keys, speed: ["KeyG"] },
    };
    press("keydown", "KeyG");
    press("keydown", "KeyZ");
    press("keydown", "KeyH", { ctrlKey: true });
    expect(sent).toEqual([]);
  });

  it("does nothing without permission", () => {
    state.room.value = room({ operator: BOB, watching: [ADA], number: 8 });
    press("keydown", "KeyG");
    expect(sent).toEqual([]);
  });
});

it("ignores a room state that is gone", () => {
  operating.press("finger", "horn");
  state.room.value = null;
  expect(newest()?.held).toEqual({});
  state.room.value = {
    ...room({
      operator: ADA,
      number: 7,
      stop: pressedBy("Bob"),
    }),
  };
  operating.press("finger", "horn");
  expect(newest()?.held).toEqual({ horn: 1 });
});
