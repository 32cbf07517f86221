// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { describe, expect, it } from "vitest";
import { type Direction, fingerHolder } from "../drive/inputState";
import { listenKeyboard } from "../drive/keyboard";
import { DEFAULT_KEYS } from "../drive/keyMap";
import { says } from "../words/said";
import {
  actions,
  body,
  button,
  drawsPage,
  input,
  key,
  movesSideways,
  open,
  pointer,
  show,
  state,
} from "./page.test.setup";

drawsPage();

/** What the buttons of a robot that moves sideways are called, row by row. */
const SIX = ["Left sideways", "Forward", "Right sideways", "Turn left", "Back", "Turn right"];

describe("every control is found by its role and name", () => {
  it.each(["Turn sound on", "Join the queue", "Stop", "People", "Settings", "Details", "Safety"])(
    "button %s, while watching",
    (name) => {
      show({ watching: [1] });
      expect(button(name)).toBeTruthy();
    },
  );

  it.each(["Forward", "Back", "Left", "Right", "Stop"])("button %s, in the queue", (name) => {
    show({ operator: 2, waiting: [1] });
    expect(button(name)).toBeTruthy();
  });

  it("offers an observer no controls to drive", () => {
    show({ watching: [1] });
    expect(queryByRole(body, "button", { name: "Forward" })).toBeNull();
    expect(queryByRole(body, "group", { name: "Speed" })).toBeNull();
  });

  it("switches, speed, size, name, queue, timer and status", () => {
    show({ operator: 1 });
    expect(button("End my turn")).toBeTruthy();
    expect(getByRole(body, "switch", { name: "Sound" })).toBeTruthy();
    expect(getByRole(body, "textbox", { name: "Your name" })).toBeTruthy();
    expect(getByRole(body, "list", { name: "Queue" })).toBeTruthy();
    open("Settings");
    expect(getByRole(body, "switch", { name: "Picture" })).toBeTruthy();
    const speed = getByRole(body, "group", { name: "Speed" });
    for (const name of ["Slow", "Fast"]) expect(getByRole(speed, "button", { name })).toBeTruthy();
    for (const name of ["Picture size"]) expect(getByRole(body, "combobox", { name })).toBeTruthy();
    expect(getByRole(body, "timer").textContent).toContain("42 s");
    expect(getByRole(body, "status").textContent).toBe("Connected");
  });
});

describe("driving", () => {
  it("is for the operator only", () => {
    show({ operator: 2, waiting: [1] });
    expect(button("Forward").disabled).toBe(true);
    expect(queryByText(body, "You are driving")).toBeNull();
    show({ operator: 1 });
    expect(button("Forward").disabled).toBe(false);
    expect(getByText(body, "You are driving")).toBeTruthy();
  });

  it("works by the arrow keys while Slow or Fast has the focus", () => {
    show({ operator: 1 });
    const aborting = new AbortController();
    listenKeyboard(window, {
      keys: () => DEFAULT_KEYS,
      isDriving: () => true,
      isFor: () => true,
      press: (holder, action) => void input.press(holder, action as Direction),
      release: (holder) => void input.release(holder),
      anyKey: () => {},
      letGo: () => input.releaseAll(),
      signal: aborting.signal,
    });
    const speeds = getByRole(body, "group", { name: "Speed" }).querySelectorAll("*");
    const choices = [...speeds].filter(
      (one): one is HTMLElement => (one as HTMLElement).tabIndex >= 0,
    );
    expect(choices).toHaveLength(2);
    for (const one of choices) {
      one.focus();
      expect(document.activeElement).toBe(one);
      key(one, "keydown", "ArrowUp");
      expect(input.motion.linear).toBe(1);
      key(one, "keyup", "ArrowUp");
      expect(input.motion.linear).toBe(0);
    }
    expect(actions.setSpeed).not.toHaveBeenCalled();
    act(() => button("Fast").click());
    expect(actions.setSpeed).toHaveBeenCalledWith("fast");
    act(() => {
      state.preferences.value = { ...state.preferences.value, speed: "fast" };
    });
    const pressed = choices.map((one) => one.getAttribute("aria-pressed"));
    expect(pressed).toEqual(["false", "true"]);
    aborting.abort();
  });

  it("is announced as nearly over once, for screen readers", () => {
    show({ operator: 1 });
    const ends = "10 seconds left.";
    const endsMs = state.room.value?.turn.ends_server_ms ?? 0;
    act(() => {
      state.serverMs.value = endsMs - 10_500;
    });
    expect(queryByText(body, ends)).toBeNull();
    for (const leftMs of [9900, 5000]) {
      act(() => {
        state.serverMs.value = endsMs - leftMs;
      });
      expect(getByText(body, ends).closest("[aria-live=assertive]")).toBeTruthy();
    }
  });

  it("ends with the connection", () => {
    show({ operator: 1 });
    act(() => {
      state.link.value = { is: "waiting", retryAtMs: 3000, reason: says("The server is gone.") };
    });
    expect(button("Forward").disabled).toBe(true);
    expect(queryByText(body, "You are driving")).toBeNull();
    expect(getByRole(body, "status").textContent).toBe("Reconnecting in 3 s: The server is gone.");
  });

  it("lasts as long as each finger rests on its button", () => {
    show({ operator: 1 });
    pointer(button("Forward"), "pointerdown", 1);
    pointer(button("Left"), "pointerdown", 2);
    expect(input.motion).toEqual({ linear: 1, angular: 1 });
    pointer(button("Forward"), "pointerup", 1);
    pointer(button("Forward"), "lostpointercapture", 1);
    expect(input.motion).toEqual({ linear: 0, angular: 1 });
    expect(actions.letGo).not.toHaveBeenCalled();
  });

  it.each(["pointercancel", "lostpointercapture"])("releases everything on %s", (type) => {
    show({ operator: 1 });
    pointer(button("Forward"), "pointerdown", 1);
    pointer(button("Left"), "pointerdown", 2);
    pointer(button("Forward"), type, 1);
    expect(actions.letGo).toHaveBeenCalled();
    expect(input.motion).toEqual({ linear: 0, angular: 0 });
  });

  it("has no control that moves sideways on a robot that cannot", () => {
    show({ operator: 1 });
    expect(queryByRole(body, "button", { name: /sideways/ })).toBeNull();
    expect(body.querySelector(".is-planar")).toBeNull();
    act(() => {
      state.preferences.value = { ...state.preferences.value, control: "stick" };
    });
    expect(queryByRole(body, "application", { name: "Turn left or right" })).toBeNull();
  });

  it("has two more buttons on a robot that moves sideways", () => {
    show({ operator: 1 });
    movesSideways();
    pointer(button("Left sideways"), "pointerdown", 1);
    expect(input.motion).toEqual({ linear: 0, angular: 0, lateral: 1 });
    pointer(button("Left sideways"), "pointerup", 1);
    pointer(button("Right sideways"), "pointerdown", 1);
    pointer(button("Turn left"), "pointerdown", 2);
    expect(input.motion).toEqual({ linear: 0, angular: 1, lateral: -1 });
  });

  it.each([
    ["that moves sideways", true, SIX],
    ["that does not", false, ["Forward", "Left", "Back", "Right"]],
  ])("has its buttons in the order of the rows on a robot %s", (_, isPlanar, names) => {
    show({ operator: 1 });
    if (isPlanar) movesSideways();
    const found = [...body.querySelectorAll(".drive-button")].map((one) => one.textContent);
    expect(found).toEqual(names);
  });

  it("has a stick for each thumb on a robot that moves sideways", () => {
    show({ operator: 1 });
    movesSideways();
    act(() => {
      state.preferences.value = { ...state.preferences.value, control: "stick" };
    });
    const push = (name: string, pointerId: number, right: number, down: number) => {
      const stick = getByRole(body, "application", { name });
      stick.getBoundingClientRect = () => new DOMRect(0, 0, 200, 60);
      pointer(stick, "pointerdown", pointerId);
      const move = { bubbles: true, pointerId, clientX: right, clientY: down };
      act(() => void stick.dispatchEvent(new PointerEvent("pointermove", move)));
      return stick;
    };
    push("Joystick", 1, -200, -200);
    const half = Number(Math.SQRT1_2.toFixed(3));
    const turn = push("Turn left or right", 2, 200, 500);
    expect(input.motion).toEqual({ linear: half, angular: -1, lateral: half });
    pointer(turn, "pointerup", 2);
    expect(input.motion).toEqual({ linear: half, angular: 0, lateral: half });
    expect(input.isHolding).toBe(true);
  });

  it.each(["Space", "Enter"])("works by holding %s on a focused button", (code) => {
    show({ operator: 1 });
    key(button("Back"), "keydown", code);
    expect(input.motion.linear).toBe(-1);
    key(button("Back"), "keyup", code);
    expect(input.motion.linear).toBe(0);
  });

  it("ends when a held button loses the focus", () => {
    show({ operator: 1 });
    key(button("Back"), "keydown", "Space");
    act(() => {
      button("Back").dispatchEvent(new FocusEvent("blur"));
    });
    expect(input.motion.linear).toBe(0);
  });

  it("says why the robot does not move", () => {
    show({ operator: 1 });
    act(() => {
      state.driveReason.value = { code: "drive.too_old" };
    });
    expect(
      getByText(body, "Your commands do not arrive in time: your connection is slow."),
    ).toBeTruthy();
  });

  it("has a slider for each further axis", () => {
    show({ operator: 1 }, ["pan", "tilt"]);
    const slider = getByRole<HTMLInputElement>(body, "slider", { name: "pan" });
    act(() => {
      slider.value = "0.5";
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    expect(actions.setAxis).toHaveBeenCalledWith("pan", 0.5);
    expect(getByRole(body, "slider", { name: "tilt" })).toBeTruthy();
  });

  it("counts a held slider as a held control", () => {
    show({ operator: 1 }, ["pan"]);
    const slider = getByRole(body, "slider", { name: "pan" });
    pointer(slider, "pointerdown", 4);
    expect(input.isHolding).toBe(true);
    expect(input.motion).toEqual({ linear: 0, angular: 0 });
    input.release(fingerHolder(4));
    key(slider, "keydown", "ArrowRight");
    expect(input.isHolding).toBe(true);
    key(slider, "keyup", "ArrowRight");
    expect(input.isHolding).toBe(false);
  });

  it("is emphasised in its last ten seconds", () => {
    show({ operator: 1 });
    const card = () => getByRole(body, "region", { name: "Turn" }).className;
    expect(card()).not.toContain("is-ending");
    act(() => {
      state.serverMs.value = 50_500;
    });
    expect(getByRole(body, "timer").textContent).toContain("10 s");
    expect(card()).toContain("is-ending");
  });
});
