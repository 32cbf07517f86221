// @vitest-environment dom
import { getAllByRole, getByLabelText, getByRole, queryByRole } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Actions, Session } from "../actions";
import { DRIVE_DEFAULTS } from "../drive/drivePreferences";
import type { PadState } from "../drive/gamepads";
import type { InputState } from "../drive/inputState";
import { DEFAULT_KEYS } from "../drive/keyMap";
import { UNHEARD_MS } from "../drive/keysDown";
import { loadPreferences, type Preferences } from "../preferences";
import { createState, type State } from "../state";
import { draw, undraw } from "../testing/draw";
import { eventually } from "../testing/eventually";
import { plugIn, takeAwayGamepads } from "../testing/gamepads";
import { control, hello, planar, room } from "../testing/messages";
import { Axes } from "./drive/Axes";
import { ScanPad } from "./drive/ScanPad";
import { WaysPanel } from "./drive/WaysPanel";
import { Joystick } from "./Joystick";
import { inputTo } from "./page.test.setup";

let state: State;
let input: InputState;
let actions: Pick<
  Actions,
  "press" | "deflect" | "release" | "letGo" | "recentre" | "setDriving" | "useGamepad" | "scan"
> &
  Pick<Actions, "setAxis" | "stop" | "padRestNow" | "learnPad">;
const body = document.body;

/** This page drives a robot that can pan and tilt. */
beforeEach(() => {
  state = createState(loadPreferences(null));
  input = inputTo(state);
  const mine = hello({ viewer: 1 });
  state.hello.value = { ...mine, robot: { ...mine.robot, axes: ["pan", "tilt"] } };
  state.room.value = room({ operator: 1 });
  state.link.value = { is: "connected" };
  input.enable();
  actions = {
    press: (holder, held) => input.press(holder, held),
    deflect: (holder, motion) => input.deflect(holder, motion),
    release: (holder) => input.release(holder),
    letGo: vi.fn(() => input.releaseAll()),
    recentre: vi.fn(),
    setDriving: vi.fn((change) => {
      state.preferences.value = { ...state.preferences.value, ...change };
    }),
    useGamepad: vi.fn(),
    padRestNow: vi.fn(() => null),
    learnPad: vi.fn(),
    scan: vi.fn(),
    setAxis: vi.fn(),
    stop: vi.fn(),
  };
  const session = { state, actions } as unknown as Session;
  draw(
    session,
    <>
      <Joystick use="drive" />
      <Axes />
      <ScanPad />
      <WaysPanel />
    </>,
  );
});

afterEach(undraw);

function prefer(change: Partial<Preferences>): void {
  act(() => {
    state.preferences.value = { ...state.preferences.value, ...change };
  });
}

function key(element: EventTarget, type: string, code: string, name = ""): Event {
  const event = new KeyboardEvent(type, { code, key: name, bubbles: true, cancelable: true });
  act(() => void element.dispatchEvent(event));
  return event;
}

describe("the joystick", () => {
  let stick: HTMLElement;
  let knob: HTMLElement;

  beforeEach(() => {
    stick = getByLabelText(body, "Joystick");
    knob = stick.querySelector(".joystick-knob") as HTMLElement;
    stick.setPointerCapture = vi.fn();
    stick.getBoundingClientRect = () => new DOMRect(100, 100, 200, 200);
  });

  /** Touches, moves or lifts a finger this far right and down of the middle. */
  function finger(type: string, right = 0, down = 0, pointerId = 1, button = 0): void {
    const [clientX, clientY] = [200 + right, 200 + down];
    const more = { bubbles: true, cancelable: true, pointerId, button, clientX, clientY };
    act(() => void stick.dispatchEvent(new PointerEvent(type, more)));
  }

  /** Touches the middle, and pushes from there. */
  function push(right: number, down: number): void {
    finger("pointerdown");
    finger("pointermove", right, down);
  }

  const isInTheMiddle = () => knob.style.translate === "0% 0%";

  it("has a name, and describes the alternative", () => {
    expect(stick.getAttribute("aria-describedby")).toBe("joystick-help");
    expect(document.getElementById("joystick-help")?.textContent).toContain("keys");
    expect(stick.tabIndex).toBe(0);
  });

  it("holds the dead-man switch in its middle, and moves in proportion to the push", () => {
    finger("pointerdown");
    expect(input.isHolding).toBe(true);
    expect(input.motion).toEqual({ linear: 0, angular: 0 });
    finger("pointermove", 0, -35);
    const half = input.motion.linear;
    expect(half).toBeGreaterThan(0.1);
    expect(half).toBeLessThan(0.6);
    finger("pointermove", 0, -500);
    expect(input.motion).toEqual({ linear: 1, angular: 0 });
    finger("pointermove", -500, 0);
    expect(input.motion.angular).toBe(1);
    expect(isInTheMiddle()).toBe(false);
  });

  it("moves nothing by a touch alone, wherever it lands, and measures the push from there", () => {
    finger("pointerdown", 60, -60);
    expect(input.isHolding).toBe(true);
    expect(input.motion).toEqual({ linear: 0, angular: 0 });
    finger("pointermove", 60, -130);
    expect(input.motion).toEqual({ linear: 1, angular: 0 });
  });

  it.each(["pointerup", "pointercancel", "lostpointercapture"])("releases on %s", (type) => {
    push(0, -70);
    expect(input.motion.linear).toBe(1);
    finger(type, 0, -70);
    expect(input.isHolding).toBe(false);
    expect(isInTheMiddle()).toBe(true);
    expect(actions.letGo).toHaveBeenCalledTimes(type === "pointerup" ? 0 : 1);
    finger("pointermove", 0, -70);
    expect(input.isHolding).toBe(false);
  });

  it("ignores a second finger", () => {
    push(0, -70);
    finger("pointerdown", 0, 70, 2);
    finger("pointermove", 0, 70, 2);
    expect(input.motion).toEqual({ linear: 1, angular: 0 });
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) finger(type, 0, 70, 2);
    expect(input.motion).toEqual({ linear: 1, angular: 0 });
    finger("pointerup", 0, -70);
    expect(input.isHolding).toBe(false);
  });

  it("springs back when everything is released, and moves nothing until it is taken again", () => {
    push(0, -70);
    act(() => input.releaseAll());
    expect(isInTheMiddle()).toBe(true);
    finger("pointermove", 0, -60);
    finger("pointermove", 0, -70);
    expect(input.isHolding).toBe(false);
    expect(isInTheMiddle()).toBe(true);
    finger("pointerup", 0, -70);
    push(0, -70);
    expect(input.motion.linear).toBe(1);
  });

  it("releases when it is removed from the page", () => {
    push(0, -70);
    undraw();
    expect(input.isHolding).toBe(false);
  });

  it("ignores other mouse buttons, and any touch while this page may not move", () => {
    finger("pointerdown", 0, -70, 1, 2);
    expect(input.isHolding).toBe(false);
    act(() => {
      state.room.value = room({ operator: 2 });
    });
    expect(stick.getAttribute("aria-disabled")).toBe("true");
    finger("pointerdown", 0, -70);
    expect(input.isHolding).toBe(false);
    expect(isInTheMiddle()).toBe(true);
  });
});

describe("the axes", () => {
  it("have a slider each, with its keys, and one button to centre them", () => {
    const sliders = getAllByRole(getByRole(body, "group", { name: "Axes" }), "slider");
    expect(sliders.map((one) => one.getAttribute("aria-keyshortcuts"))).toEqual(["J L", "I K"]);
    expect(sliders.map((one) => one.getAttribute("dir"))).toEqual(["rtl", "ltr"]);
    act(() => getByRole(body, "button", { name: "Recentre" }).click());
    expect(actions.recentre).toHaveBeenCalledOnce();
  });

  it("are held by a key that slides, and by no other", () => {
    const slider = getByRole(body, "slider", { name: "pan" });
    key(slider, "keydown", "Tab");
    expect(input.isHolding).toBe(false);
    key(slider, "keydown", "ArrowLeft");
    expect(input.isHolding).toBe(true);
    key(slider, "keyup", "ArrowLeft");
    expect(input.isHolding).toBe(false);
  });
});

describe("an axis that a key without a code holds", () => {
  it("is released if the keyup never comes", () => {
    vi.useFakeTimers();
    const slider = getByRole(body, "slider", { name: "pan" });
    key(slider, "keydown", "", "ArrowLeft");
    vi.advanceTimersByTime(UNHEARD_MS - 1);
    expect(input.isHolding).toBe(true);
    act(() => void vi.advanceTimersByTime(1));
    expect(input.isHolding).toBe(false);
  });
});

describe("a robot that moves sideways", () => {
  beforeEach(() => {
    act(() => {
      state.hello.value = planar(hello({ viewer: 1 }));
    });
  });

  it("has two more directions on offer to a switch", () => {
    act(() => {
      state.scan.value = "lateral_left";
    });
    const items = [...body.querySelectorAll(".scan-item")].map((one) => one.textContent);
    expect(items).toEqual([
      "Forward",
      "Turn left",
      "Turn right",
      "Left sideways",
      "Right sideways",
      "Back",
      "Stop",
    ]);
    expect(body.querySelector("[aria-current]")?.textContent).toBe("Left sideways");
  });

  it("shows its keys, and takes new ones, with Shift too", () => {
    expect(getByLabelText(body, "Take ← away from “Turn left”")).toBeTruthy();
    for (const name of ["Q", "Shift+←"])
      expect(getByLabelText(body, `Take ${name} away from “Left sideways”`)).toBeTruthy();
    act(() => getByRole(body, "button", { name: "Add a key for “Left sideways”" }).click());
    const press = (code: string) =>
      act(() => {
        const told = { code, shiftKey: true, bubbles: true, cancelable: true };
        body.dispatchEvent(new KeyboardEvent("keydown", told));
      });
    press("ShiftLeft");
    expect(body.querySelector(".ways-told")?.textContent).toContain("Press the new key");
    press("KeyX");
    expect(state.preferences.value.keys.lateral_left).toContain("Shift+KeyX");
  });

  it("has its own choice of sticks on a gamepad, and the buttons that move it sideways", () => {
    plugIn([]);
    const found = [{ index: 1, id: "Xbox", layout: "standard" as const }];
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: true, held: [], unmoved: [] };
    });
    const choice = getByRole<HTMLSelectElement>(body, "combobox", { name: "Turn with" });
    expect(choice.selectedOptions[0]?.text).toBe("Right stick; the left one drives");
    choice.value = "left";
    act(() => void choice.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setDriving).toHaveBeenLastCalledWith({
      gamepad: { ...DRIVE_DEFAULTS.gamepad, planarTurn: "left" },
    });
    expect(body.textContent).toContain("LB and RB move sideways");
    takeAwayGamepads();
  });

  it("is not said to be moved sideways by a gamepad of an unknown layout, which cannot", () => {
    plugIn([]);
    const found = [{ index: 1, id: "Stick", layout: "unknown" as const }];
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: true, held: [], unmoved: [] };
    });
    const choice = getByRole<HTMLSelectElement>(body, "combobox", { name: "Turn with" });
    expect(choice.selectedOptions[0]?.text).toBe("Left stick");
    takeAwayGamepads();
  });
});

describe("the offer to a switch", () => {
  it("is shown, with a button for each switch", () => {
    expect(queryByRole(body, "group", { name: "On offer" })).toBeNull();
    act(() => {
      state.scan.value = "left";
    });
    const current = () => body.querySelector("[aria-current]")?.textContent;
    expect(current()).toBe("Left");
    act(() => getByRole(body, "button", { name: "Choose" }).click());
    expect(actions.scan).toHaveBeenLastCalledWith("select");
    expect(queryByRole(body, "button", { name: "Next" })).toBeNull();
    prefer({ switches: 2 });
    act(() => getByRole(body, "button", { name: "Next" }).click());
    expect(actions.scan).toHaveBeenLastCalledWith("next");
    act(() => {
      state.scan.value = "release";
    });
    expect(current()).toBe("Release the stop");
  });
});

describe("the way to drive", () => {
  it("is chosen, clicks only if the host allows them", () => {
    const clicks = getByRole<HTMLInputElement>(body, "radio", { name: "Clicks" });
    expect(clicks.disabled).toBe(true);
    act(() => getByRole(body, "radio", { name: "Steps" }).click());
    expect(actions.setDriving).toHaveBeenLastCalledWith({ way: "step" });
    act(() => {
      state.hello.value = hello({ viewer: 1, click_to_move: true });
    });
    expect(clicks.disabled).toBe(false);
  });

  it("has its own settings: a step's length, the number of switches and their time", () => {
    expect(queryByRole(body, "slider", { name: /Length of a step/ })).toBeNull();
    prefer({ way: "scan" });
    const length = getByRole<HTMLInputElement>(body, "slider", { name: /Length of a step/ });
    length.value = "700";
    act(() => void length.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setDriving).toHaveBeenLastCalledWith({ stepMs: 700 });
    expect(getByRole(body, "slider", { name: /Time for each/ })).toBeTruthy();
    const switches = getByRole<HTMLSelectElement>(body, "combobox", { name: "Switches" });
    switches.value = "2";
    act(() => void switches.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setDriving).toHaveBeenLastCalledWith({ switches: 2 });
    expect(queryByRole(body, "slider", { name: /Time for each/ })).toBeNull();
  });
});

describe("a gamepad", () => {
  it("is chosen by its name, and then has settings", () => {
    expect(queryByRole(body, "combobox", { name: "Gamepad" })).toBeNull();
    const found = [{ index: 1, id: "Xbox", layout: "standard" as const }];
    act(() => {
      state.pads.value = { found, chosen: null, isReady: false, held: [], unmoved: [] };
    });
    const pads = getByRole<HTMLSelectElement>(body, "combobox", { name: "Gamepad" });
    pads.value = "1";
    act(() => void pads.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.useGamepad).toHaveBeenLastCalledWith(1);
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: false, held: [], unmoved: [] };
    });
    expect(getByRole<HTMLSelectElement>(body, "combobox", { name: "Turn with" }).value).toBe(
      "left",
    );
    act(() => getByRole(body, "switch", { name: /Triggers/ }).click());
    expect(actions.setDriving).toHaveBeenLastCalledWith({
      gamepad: { ...DRIVE_DEFAULTS.gamepad, triggers: false },
    });
    pads.value = "";
    act(() => void pads.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.useGamepad).toHaveBeenLastCalledWith(null);
  });
});

describe("the status of a gamepad", () => {
  const shown = (layout: "standard" | "unknown" | "bare", more: Partial<PadState>) => {
    const found = [{ index: 1, id: "Stick", layout }];
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: false, held: [], unmoved: [], ...more };
    });
    return body.querySelector(".ways-group p[aria-live]")?.textContent?.trim();
  };

  it("names what is held, and only buttons that work", () => {
    plugIn([]);
    const held = [
      { kind: "axis", at: 1 },
      { kind: "button", at: 1 },
    ] as const;
    expect(shown("unknown", { held })).toContain(
      "Held: axis 2, button 2. If nobody is touching the gamepad",
    );
    expect(shown("standard", { held })).toContain("Held: Left stick, B. ");
    expect(shown("standard", { isReady: true })).toContain("B stops, A changes");
    expect(shown("unknown", { isReady: true })).toContain("button 2 stops, button 1 changes");
    expect(shown("bare", { isReady: true })).toContain("no button for Stop");
    takeAwayGamepads();
  });
});

describe("the parts of a gamepad", () => {
  const wish = () => vi.mocked(actions.learnPad).mock.lastCall?.[0];
  const asks = (name: string) =>
    act(() => getByRole(body, "button", { name: `Choose a part for “${name}”` }).click());
  const learnt = () => state.preferences.value.gamepad.learnt;

  beforeEach(() => {
    state.hello.value = hello({ controls: [control("horn", { pad_button: "X" })] });
    const found = [{ index: 1, id: "Stick", layout: "standard" as const }];
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: true, held: [], unmoved: [] };
    });
  });

  it("are chosen by pressing them, and taken away again", () => {
    asks("horn");
    expect(body.textContent).toContain("Press or push, on the gamepad");
    expect(wish()?.isAxis).toBe(false);
    act(() => wish()?.found({ kind: "button", at: 10, to: 1, from: 0 }));
    expect(learnt()).toEqual({ Stick: { "control horn": { kind: "button", at: 10, to: 1 } } });
    expect(wish()).toBeNull();
    asks("Stop");
    act(() => wish()?.found({ kind: "button", at: 10, to: 1, from: 0 }));
    expect(body.textContent).toContain("“LS” is already for “horn”");
    expect(learnt().Stick?.stop).toBeUndefined();
    act(() => getByRole(body, "button", { name: "Take LS away from “horn”" }).click());
    expect(learnt()).toEqual({ Stick: {} });
  });

  it("include axes beyond the sticks', each with where it rests", () => {
    asks("Go ahead");
    expect(wish()?.isAxis).toBe(true);
    act(() => wish()?.found({ kind: "axis", at: 5, to: 1, from: -1.0001 }));
    expect(learnt().Stick).toEqual({ ahead: { kind: "axis", at: 5, to: 1 } });
    expect(state.preferences.value.gamepad.rests.Stick).toEqual([0, 0, 0, 0, 0, -1]);
    asks("Turn left");
    asks("Turn left");
    expect(wish()).toBeNull();
  });
});

describe("the rest of a gamepad's axis", () => {
  const button = () => queryByRole(body, "button", { name: "This is how it rests" });
  const holds = (held: PadState["held"], more: Partial<PadState> = {}) => {
    const found = [{ index: 1, id: "Stick", layout: "unknown" as const }];
    act(() => {
      state.pads.value = { found, chosen: 1, isReady: false, held, unmoved: [], ...more };
    });
  };

  it("can be set if an axis seems held, and is stored if the axes are still", () => {
    plugIn([]);
    holds([{ kind: "button", at: 1 }]);
    expect(button()).toBeNull();
    const before = { ...DRIVE_DEFAULTS.gamepad, rests: { Other: [0, 0.5, 0] } };
    prefer({ gamepad: before });
    holds([{ kind: "axis", at: 1 }]);
    act(() => button()?.click());
    expect(body.textContent).toContain("has not been at rest for a second");
    expect(actions.setDriving).not.toHaveBeenCalled();
    vi.mocked(actions.padRestNow).mockReturnValue([0, -1, 0]);
    act(() => button()?.click());
    expect(body.textContent).not.toContain("has not been at rest for a second");
    expect(actions.setDriving).toHaveBeenLastCalledWith({
      gamepad: { ...before, rests: { Other: [0, 0.5, 0], Stick: [0, -1, 0] } },
    });
    holds([], { unmoved: [{ kind: "axis", at: 1 }] });
    expect(button()).toBeNull();
    expect(body.textContent).toContain("Move axis 2 once and let go");
    takeAwayGamepads();
  });
});

describe("the keys", () => {
  const told = () => body.querySelector(".ways-told")?.textContent;

  function asks(name: string): void {
    act(() => getByRole(body, "button", { name: `Add a key for “${name}”` }).click());
  }

  it("are changed by pressing a new one, which does nothing else meanwhile", () => {
    const elsewhere = vi.fn();
    window.addEventListener("keydown", elsewhere);
    asks("Forward");
    expect(told()).toContain("Press the new key for “Forward”");
    expect(key(body, "keydown", "KeyE").defaultPrevented).toBe(true);
    expect(elsewhere).not.toHaveBeenCalled();
    expect(state.preferences.value.keys.forward).toEqual(["ArrowUp", "KeyW", "KeyE"]);
    key(body, "keydown", "KeyQ");
    expect(elsewhere).toHaveBeenCalledOnce();
    window.removeEventListener("keydown", elsewhere);
  });

  it("listen for one key as soon as they ask for it, and for only one", async () => {
    const elsewhere = vi.fn();
    window.addEventListener("keydown", elsewhere);
    // Without `act`, which would wait some frames.
    const says = (what: string) =>
      eventually(() => expect(told()?.slice(0, what.length || 1)).toBe(what), 1);
    const press = (code: string) =>
      window.dispatchEvent(new KeyboardEvent("keydown", { code, cancelable: true }));
    getByRole(body, "button", { name: "Add a key for “Forward”" }).click();
    await says("Press the new key");
    press("KeyE");
    expect(elsewhere).not.toHaveBeenCalled();
    await says("");
    press("KeyQ");
    expect(elsewhere).toHaveBeenCalledOnce();
    expect(state.preferences.value.keys.forward).toEqual(["ArrowUp", "KeyW", "KeyE"]);
    window.removeEventListener("keydown", elsewhere);
  });

  it.each([
    ["KeyS", "S is already the key for “Back”; take it away there first."],
    ["Tab", "Tab belongs to the browser or your system; choose another key."],
    ["Escape", ""],
  ])("leave %s as it is, and say why", (code, sentence) => {
    asks("Forward");
    key(body, "keydown", code);
    expect(told()).toBe(sentence);
    expect(state.preferences.value.keys).toEqual(DEFAULT_KEYS);
  });

  it("without a code are taken by their names, and without a name are ignored", () => {
    asks("Forward");
    key(body, "keydown", "", "Process");
    expect(told()).toContain("Press the new key for “Forward”");
    key(body, "keydown", "", "e");
    expect(state.preferences.value.keys.forward).toEqual(["ArrowUp", "KeyW", "KeyE"]);
  });

  it("stop the robot by Space even now", () => {
    asks("Forward");
    key(body, "keydown", "Space");
    expect(actions.stop).toHaveBeenCalledOnce();
    expect(told()).toContain("Space is already the key for “Stop”");
  });

  it("move the focus to the neighbour of a key removed by keyboard", () => {
    const button = (name: string) => getByRole(body, "button", { name });
    const click = (name: string, detail: number) =>
      act(() => {
        button(name).focus();
        button(name).dispatchEvent(new MouseEvent("click", { bubbles: true, detail }));
      });
    click("Take ↑ away from “Forward”", 0);
    expect(document.activeElement).toBe(button("Take W away from “Forward”"));
    click("Take W away from “Forward”", 0);
    expect(document.activeElement).toBe(button("Add a key for “Forward”"));
    // A key that stays keeps the focus; after a pointer nothing has it, so that Space still stops.
    click("Take Space away from “Stop”", 0);
    expect(document.activeElement).toBe(button("Take Space away from “Stop”"));
    click("Take S away from “Back”", 1);
    expect(document.activeElement?.closest("li")).toBeFalsy();
  });

  it("are removed, except Space, and can all be reset", () => {
    act(() => getByRole(body, "button", { name: "Take W away from “Forward”" }).click());
    expect(state.preferences.value.keys.forward).toEqual(["ArrowUp"]);
    act(() => getByRole(body, "button", { name: "Take Space away from “Stop”" }).click());
    expect(told()).toContain("Space always stops the robot");
    act(() => getByRole(body, "button", { name: "Reset keys" }).click());
    expect(state.preferences.value.keys).toEqual(DEFAULT_KEYS);
  });

  it("are shown only for actions that this robot supports", () => {
    const names = () => getAllByRole(body, "listitem").map((one) => one.textContent);
    expect(names().some((one) => one?.includes("First axis"))).toBe(true);
    act(() => {
      state.hello.value = hello({ viewer: 1 });
    });
    for (const name of ["First axis", "Recentre", "Speak", "cameras", "on offer", "sideways"])
      expect(names().some((one) => one?.includes(name))).toBe(false);
  });
});
