// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Drive, Operate } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { controllerOf } from "../testing/driving";
import {
  type FakePad,
  loadGamepads,
  pad,
  plugIn,
  push,
  readings,
  takeAwayGamepads,
} from "../testing/gamepads";
import { control, hello, planar, pressedBy, room } from "../testing/messages";
import type { DriveController } from "./driveController";
import { fingerHolder } from "./inputState";
import type { Way } from "./ways";

const ADA = 1;
const BOB = 2;
const FINGER = 3;

let state: State;
let sent: Drive[];
let operated: Operate[];
let aborting: AbortController;
let controller: DriveController;
let pads: (FakePad | null)[];
let mine: FakePad;

beforeEach(async () => {
  vi.useFakeTimers();
  vi.spyOn(document, "hasFocus").mockReturnValue(true);
  sent = [];
  operated = [];
  mine = pad();
  pads = [mine];
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: ADA, click_to_move: true, command_rate_hz: 50 });
  state.link.value = { is: "connected" };
  controller = controllerOf(state, {
    operate: (operate) => operated.push(operate),
    send: (drive) => sent.push(drive),
  });
  aborting = new AbortController();
  const nothing = () => {};
  const callbacks = { releaseStop: nothing, toggleSpeed: nothing, tellOfPad: nothing };
  controller.listen(window, { stop: () => controller.letGo(), ...callbacks }, aborting.signal);
  await loadGamepads();
  state.room.value = room({ operator: ADA, number: 7 });
});

afterEach(() => {
  aborting.abort();
  readings(2);
  takeAwayGamepads();
});

function key(type: "keydown" | "keyup", code: string, repeat = false): void {
  const event = new KeyboardEvent(type, { code, repeat, bubbles: true, cancelable: true });
  document.body.dispatchEvent(event);
}

function drivesBy(way: Way): void {
  state.preferences.value = { ...state.preferences.value, way, stepMs: 1000 };
}

/** Drives with a gamepad that was chosen and released once. */
function byPad(hold: () => void): () => void {
  return () => {
    plugIn(pads);
    controller.useGamepad(0);
    readings(2);
    hold();
    readings(2);
  };
}

const finger = fingerHolder(FINGER);

function movesSideways(): void {
  state.hello.value = planar(hello({ viewer: ADA, command_rate_hz: 50 }));
}

function hasControls(): void {
  const controls = [
    control("spin", { moves: true }),
    control("lift", { kind: "slider", moves: true }),
    control("horn", { key: "KeyG" }),
  ];
  state.hello.value = hello({ viewer: ADA, controls });
}

const byFinger = (way: Way) => () => {
  drivesBy(way);
  controller.ways.press(finger, "forward");
};

/** Every way to drive: how it begins, and how it continues while held. */
const INPUTS: Record<string, [begin: () => void, goOn?: () => void]> = {
  "a key": [() => key("keydown", "ArrowUp"), () => key("keydown", "ArrowUp", true)],
  "a button": [byFinger("hold")],
  "the joystick": [
    () => controller.ways.press(finger, { linear: 0.5, angular: 0 }),
    () => controller.deflect(finger, { linear: 0.6, angular: 0 }),
  ],
  "a gamepad's stick": [
    byPad(() => {
      mine.axes[1] = -1;
    }),
    () => readings(5),
  ],
  "a key that moves sideways": [
    () => {
      movesSideways();
      key("keydown", "KeyQ");
    },
    () => key("keydown", "KeyQ", true),
  ],
  "a stick for each thumb": [
    () => {
      movesSideways();
      controller.ways.press(finger, { linear: 0, angular: 0, lateral: 0.5 });
      controller.ways.press("pointer 9", { linear: 0, angular: 0.5 });
    },
    () => {
      controller.deflect(finger, { linear: 0, angular: 0, lateral: 0.6 });
      controller.deflect("pointer 9", { linear: 0, angular: 0.6 });
    },
  ],
  "a gamepad's sticks": [
    () => {
      movesSideways();
      byPad(() => {
        [mine.axes[0], mine.axes[2]] = [-1, 1];
      })();
    },
    () => readings(5),
  ],
  "a gamepad's LB": [
    () => {
      movesSideways();
      byPad(() => push(mine, 4))();
    },
    () => readings(5),
  ],
  "a gamepad's trigger": [byPad(() => push(mine, 7)), () => readings(5)],
  "a gamepad's cross": [byPad(() => push(mine, 12)), () => readings(5)],
  "a step": [byFinger("step")],
  "a click": [byFinger("click")],
  "a switch": [
    () => {
      drivesBy("scan");
      key("keydown", "Enter");
    },
  ],
  "a control that moves": [
    () => {
      hasControls();
      controller.operating.press(finger, "spin");
    },
    () => controller.operating.inputChanged(),
  ],
  "a slider that moves": [
    () => {
      hasControls();
      controller.operating.press(finger, "lift");
      controller.operating.slide("lift", 0.5);
    },
  ],
  "a slider that moves by itself": [
    () => {
      hasControls();
      controller.operating.slide("lift", 0.5);
    },
  ],
  "a key of an axis": [
    () => {
      const { robot } = hello();
      state.hello.value = hello({ viewer: ADA, robot: { ...robot, axes: ["pan"] } });
      key("keydown", "KeyJ");
    },
  ],
};

const hide = () => {
  vi.spyOn(document, "hidden", "get").mockReturnValue(true);
  document.dispatchEvent(new Event("visibilitychange"));
};

/** Everything that releases, for every way to drive. */
const RELEASES: Record<string, () => void> = {
  blur: () => window.dispatchEvent(new Event("blur")),
  hidden: hide,
  pagehide: () => window.dispatchEvent(new Event("pagehide")),
  freeze: () => document.dispatchEvent(new Event("freeze")),
  "a menu over the page": () => window.dispatchEvent(new Event("contextmenu")),
  "another app": () => {
    window.dispatchEvent(new Event("blur"));
    hide();
  },
  "Space, which stops": () => key("keydown", "Space"),
  "the turn's end": () => {
    state.room.value = room({ operator: BOB, number: 8 });
  },
  "a turn after this one": () => {
    state.room.value = room({ operator: ADA, number: 8 });
  },
  "a latched stop": () => {
    state.room.value = room({
      operator: ADA,
      number: 7,
      stop: pressedBy("Bob"),
    });
  },
  "a lost link": () => {
    state.link.value = { is: "connecting", reason: null };
  },
};

describe.each(Object.entries(INPUTS))("what %s holds", (_, [begin, goOn]) => {
  beforeEach(() => {
    begin();
    expect(sent.at(-1)).toMatchObject({ held: true });
  });

  it.each(Object.entries(RELEASES))("is released by %s, and stays so", (_, release) => {
    sent = [];
    release();
    expect(controller.input.isHolding).toBe(false);
    expect(sent[0]).toMatchObject({ held: false, linear: 0, angular: 0, axes: {} });
    expect(sent[0]?.lateral ?? 0).toBe(0);
    goOn?.();
    vi.advanceTimersByTime(2500);
    goOn?.();
    expect(sent.some(({ held }) => held)).toBe(false);
    expect(controller.input.isHolding).toBe(false);
  });
});

describe.each(["spin", "lift", "horn", "the horn's key"])(
  "%s, one of the robot's controls",
  (name) => {
    beforeEach(() => {
      hasControls();
      if (name === "the horn's key") key("keydown", "KeyG");
      else controller.operating.press(finger, name);
      if (name === "lift") controller.operating.slide(name, 0.5);
      expect(Object.keys(operated.at(-1)?.held ?? {})).toHaveLength(1);
    });

    it.each(Object.entries(RELEASES))("is released by %s, and stays so", (_, release) => {
      operated = [];
      release();
      expect(operated[0]).toMatchObject({ held: {} });
      vi.advanceTimersByTime(2500);
      key("keydown", "KeyG", true);
      expect(operated.every(({ held }) => Object.keys(held).length === 0)).toBe(true);
      expect(state.heldControls.value.size).toBe(0);
    });
  },
);

describe.each(["spin", "horn"])("a finger on %s", (name) => {
  it.each(["pointerup", "pointercancel"])(
    "releases it by %s, and another finger does not",
    (type) => {
      hasControls();
      controller.operating.press(finger, name);
      const end = (pointerId: number) =>
        window.dispatchEvent(new PointerEvent(type, { pointerId }));
      end(FINGER + 1);
      expect(operated.at(-1)?.held).toEqual({ [name]: 1 });
      end(FINGER);
      expect(operated.at(-1)?.held).toEqual({});
    },
  );
});

describe.each(["a button", "the joystick", "a step", "a click"])("a finger on %s", (name) => {
  it("releases it when the system takes it away, and another finger does not", () => {
    INPUTS[name]?.[0]();
    const cancel = (pointerId: number) =>
      window.dispatchEvent(new PointerEvent("pointercancel", { pointerId }));
    cancel(FINGER + 1);
    expect(sent.at(-1)?.held).toBe(true);
    cancel(FINGER);
    expect(sent.at(-1)?.held).toBe(false);
  });
});

describe.each(["a button", "the joystick"])("a finger on %s", (name) => {
  it("releases it wherever it is lifted, and another finger does not", () => {
    INPUTS[name]?.[0]();
    const lift = (pointerId: number) =>
      window.dispatchEvent(new PointerEvent("pointerup", { pointerId }));
    lift(FINGER + 1);
    expect(sent.at(-1)?.held).toBe(true);
    lift(FINGER);
    expect(sent.at(-1)?.held).toBe(false);
  });
});

describe.each(["a gamepad's stick", "a gamepad's trigger", "a gamepad's cross"])("%s", (name) => {
  it.each([
    ["it vanishes", () => (pads[0] = null)],
    ["it disconnects", () => (mine.connected = false)],
  ])("is released when %s, and stays so when it is back", (_, lose) => {
    INPUTS[name]?.[0]();
    lose();
    readings(1);
    expect(sent.at(-1)).toMatchObject({ held: false, linear: 0 });
    mine.connected = true;
    plugIn([mine]);
    readings(20);
    expect(sent.at(-1)?.held).toBe(false);
  });
});

describe("a click", () => {
  beforeEach(() => byFinger("click")());

  it.each([
    ["a key", () => key("keydown", "KeyZ")],
    ["a click elsewhere", () => window.dispatchEvent(new PointerEvent("pointerdown"))],
    ["its two seconds", () => vi.advanceTimersByTime(2000)],
  ])("is ended by %s", (_, end) => {
    end();
    expect(sent.at(-1)).toMatchObject({ held: false, linear: 0 });
  });

  it("is not ended by a key that a control handles", () => {
    const event = new PointerEvent("pointerdown", { cancelable: true });
    event.preventDefault();
    window.dispatchEvent(event);
    expect(sent.at(-1)).toMatchObject({ held: true, linear: 1 });
  });
});
