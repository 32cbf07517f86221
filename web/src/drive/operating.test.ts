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
  input = new InputState({ changed, deflected: changed });
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

/** How many messages go out in this time. */
function sentIn(ms: number): number {
  const before = sent.length;
  vi.advanceTimersByTime(ms);
  return sent.length - before;
}

function roomHas(controls: Record<string, number>): void {
  state.room.value = { ...room({ operator: ADA, number: 7 }), controls };
}

describe("what is held", () => {
  it("is said at once, twenty times a second, and no more once it is released", () => {
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

  it("is held as long as any holder holds it", () => {
    operating.press("finger", "horn");
    operating.press("finger", "spin"); // which holds the horn already
    operating.press("key", "horn");
    operating.release("finger");
    expect(newest()?.held).toEqual({ horn: 1 });
    operating.release("key");
    expect(newest()?.held).toEqual({});
  });

  it("is no more than one message has room for", () => {
    for (const name of ["a", "b", "c", "d", "e"]) operating.press(name, name);
    expect(Object.keys(newest()?.held ?? {})).toEqual(["a", "b", "c", "d"]);
  });

  it("counts as driving where it moves, and only there", () => {
    operating.press("finger", "horn");
    expect(input.isHolding).toBe(false);
    operating.press("other", "spin");
    expect(input.isHolding).toBe(true);
    input.releaseAll();
    expect(newest()?.held).toEqual({ horn: 1 });
  });

  it("does not begin to move while driving is not possible", () => {
    input.disable();
    operating.press("finger", "spin");
    operating.slide("lift", 0.5);
    expect(sent).toEqual([]);
    operating.press("finger", "horn");
    expect(newest()?.held).toEqual({ horn: 1 });
  });

  it("is released when the page hung, for nobody knows what happened meanwhile", () => {
    operating.press("finger", "horn");
    const hungMs = performance.now() + 700;
    vi.spyOn(performance, "now").mockImplementation(() => hungMs);
    vi.advanceTimersByTime(50);
    expect(newest()?.held).toEqual({});
    vi.restoreAllMocks();
  });

  it("is not said while the clocks are not aligned", () => {
    serverMs = null;
    operating.press("finger", "horn");
    expect(sentIn(500)).toBe(0);
    serverMs = 6000;
    expect(sentIn(50)).toBe(1);
  });

  it("is let go of when it is refused, and the reason is said once", () => {
    const why = { code: "control.stopped" };
    operating.press("finger", "spin");
    answer(newest()?.seq, why);
    expect(refused).toEqual([why]);
    expect(newest()?.held).toEqual({});
    expect(input.isHolding).toBe(false);
  });

  it("is let go of three times within one task, if anything is held", () => {
    operating.letGo();
    expect(sent).toEqual([]);
    operating.press("finger", "horn");
    sent = [];
    operating.letGo();
    expect(sent.map(({ held }) => held)).toEqual([{}, {}, {}, {}]);
  });
});

describe("a slider that moves", () => {
  it("moves once it is slid, and no longer than it is held", () => {
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

  it("is held for a moment after each change where nobody tells of a release", () => {
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

describe("what is set", () => {
  it("is said at once and again until it has arrived, and shown meanwhile", () => {
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

  it("is shown until it has arrived, whatever the room says meanwhile", () => {
    operating.toggle("lamp");
    roomHas({ lamp: 1 });
    roomHas({ lamp: 0 });
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
    answer();
    roomHas({ lamp: 0, dim: 3 });
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
  });

  it("arrives though nine of ten messages and answers are lost", () => {
    operating.set("light", 1);
    vi.advanceTimersByTime(1200);
    answer(sent[0]?.seq);
    expect(sentIn(2000)).toBe(0);
    expect(refused).toEqual([]);
  });

  it("is not taken for what was set before it", () => {
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

  it("goes with what is held, no more often than the server takes it", () => {
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

  it("goes two at a time", () => {
    operating.set("lamp", 1);
    operating.set("dim", 5);
    operating.set("light", 1);
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ lamp: 1, dim: 5 });
    answer();
    vi.advanceTimersByTime(150);
    expect(newest()?.wanted).toEqual({ light: 1 });
  });

  it("is given up when it does not arrive, which is said", () => {
    operating.toggle("lamp");
    vi.advanceTimersByTime(3200);
    expect(refused).toEqual([null]);
    expect(state.wantedControls.value).toEqual({});
    expect(sentIn(1000)).toBe(0);
  });

  it("is shown as the room has it when it is refused, or nobody tells of it", () => {
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

  it("is forgotten when a turn ends", () => {
    operating.set("dim", 5);
    state.room.value = room({ operator: BOB, watching: [ADA], number: 8 });
    expect(state.wantedControls.value).toEqual({});
    expect(sentIn(1000)).toBe(0);
  });

  it("ignores answers to what it has not asked", () => {
    operating.toggle("lamp");
    answer(99);
    expect(state.wantedControls.value).toEqual({ lamp: 1 });
  });
});

describe("who may", () => {
  const names = () => state.usableControls.value.map(({ name }) => name);

  it("is decided by the roles that the host has given each", () => {
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

  it("is nobody without a connection, or who watches in a room", () => {
    state.isInRoom.value = true;
    expect(names()).toEqual([]);
    state.isInRoom.value = false;
    state.link.value = { is: "connecting", reason: null };
    expect(names()).toEqual([]);
    state.hello.value = null;
    state.link.value = { is: "connected" };
    expect(names()).toEqual([]);
  });

  it("is no operator while the person aboard has the robot", () => {
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

  it("holds a button and switches a toggle", () => {
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

  it("that the user has given something, or that nothing has, does not", () => {
    state.preferences.value = {
      ...state.preferences.value,
      keys: { ...state.preferences.value.keys, speed: ["KeyG"] },
    };
    press("keydown", "KeyG");
    press("keydown", "KeyZ");
    press("keydown", "KeyH", { ctrlKey: true });
    expect(sent).toEqual([]);
  });

  it("is no use to who may not", () => {
    state.room.value = room({ operator: BOB, watching: [ADA], number: 8 });
    press("keydown", "KeyG");
    expect(sent).toEqual([]);
  });
});

it("says nothing of a room that is gone", () => {
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
