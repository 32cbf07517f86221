// @vitest-environment dom
import { getAllByRole, getByRole, queryByRole } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import type { Actions } from "../actions";
import type { DriveController } from "../drive/driveController";
import { UNHEARD_MS } from "../drive/keysDown";
import type { ControlInfo, GaugeInfo, Operate, RobotStatus } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { draw, undraw } from "../testing/draw";
import { controllerOf } from "../testing/driving";
import { aboard, control, hello, pressedBy, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { ControlSet, RobotControls } from "./drive/RobotControls";
import { Gauges, GaugeWarnings } from "./Gauges";

const ADA = 1;
const BOB = 2;
const CONTROLS: ControlInfo[] = [
  control("horn", { label: "Horn", key: "KeyG" }),
  control("lamp", { label: "Lamp", kind: "toggle", key: "KeyF", roles: ["operator", "observer"] }),
  control("dim", { label: "Brightness", kind: "slider", min: 10, max: 100, step: 5 }),
  control("light", { label: "Light", kind: "choice", choices: ["white", "red"] }),
  control("spin", { label: "Look around", moves: true }),
  control("lift", { label: "Lift", kind: "slider", min: -1, moves: true }),
  control("siren", { label: "Siren", roles: ["host"] }),
];

let state: State;
let controller: DriveController;
let sent: Operate[];
let body: HTMLElement;

beforeAll(ControlSet.load);

beforeEach(() => {
  vi.useFakeTimers();
  sent = [];
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: ADA, controls: CONTROLS });
  state.link.value = { is: "connected" };
  controller = controllerOf(state, { operate: (operate) => sent.push(operate) });
  const { operating } = controller;
  const actions = {
    holdControl: (holder: string, name: string) => operating.press(holder, name),
    releaseControl: (holder: string) => operating.release(holder),
    slideControl: (name: string, value: number) => operating.slide(name, value),
    setControl: (name: string, value: number) => operating.set(name, value),
    toggleControl: (name: string) => operating.toggle(name),
    letGo: () => controller.letGo(),
  };
  body = document.body;
  draw(
    { ...testSession(state), actions: actions as Actions },
    <>
      <RobotControls />
      <Gauges />
      <GaugeWarnings />
    </>,
  );
});

afterEach(undraw);

function drives(more: Parameters<typeof room>[0] = {}): void {
  act(() => {
    state.room.value = room({ operator: ADA, number: 7, ...more });
  });
}

const button = (name: string) => getByRole<HTMLButtonElement>(body, "button", { name });
const slider = (name: string) => getByRole<HTMLInputElement>(body, "slider", { name });

function send(element: Element, type: string, init: object = {}): void {
  element.setPointerCapture = () => {};
  const Kind = type.startsWith("key") ? KeyboardEvent : PointerEvent;
  const event = new Kind(type, { bubbles: true, cancelable: true, ...init });
  act(() => void element.dispatchEvent(event));
}

function slide(element: HTMLInputElement, value: number): void {
  element.value = String(value);
  act(() => void element.dispatchEvent(new Event("input", { bubbles: true })));
}

describe("the robot's controls", () => {
  it("are shown to the operator, with names and unassigned keys", () => {
    drives();
    const shown = getAllByRole(body, "button").map((one) => one.textContent);
    expect(shown).toEqual(["HornG", "Lamp", "white", "red", "Look around"]);
    expect(button("Horn").getAttribute("aria-keyshortcuts")).toBe("G");
    expect(button("Lamp").getAttribute("aria-keyshortcuts")).toBe(null);
    expect(getByRole(body, "group", { name: "Light" })).toBeTruthy();
    expect(slider("Brightness").min).toBe("10");
    expect(queryByRole(body, "button", { name: /Siren/ })).toBe(null);
  });

  it("are offered to observers and the host by the host's settings", () => {
    drives({ operator: BOB, watching: [ADA] });
    expect(getAllByRole(body, "button").map((one) => one.textContent)).toEqual(["Lamp"]);
    act(() => {
      state.hello.value = hello({ viewer: ADA, controls: CONTROLS, is_host: true });
    });
    expect(getAllByRole(body, "button").map((one) => one.textContent)).toEqual(["Lamp", "Siren"]);
  });

  it("are disabled for the operator while the person aboard has the robot", () => {
    act(() => {
      const now = room({ operator: ADA, number: 7 });
      state.room.value = { ...now, aboard: aboard({ mode: "hand" }) };
    });
    expect(button("Horn").disabled).toBe(true);
    expect(button("Lamp").disabled).toBe(false);
  });

  it("are absent if the robot has none, or in a LiveKit room", () => {
    drives();
    act(() => {
      state.isInRoom.value = true;
    });
    expect(queryByRole(body, "group")).toBe(null);
    act(() => {
      state.isInRoom.value = false;
      state.hello.value = hello({ viewer: ADA });
    });
    expect(queryByRole(body, "group")).toBe(null);
  });

  it("are held by a finger, and by Space or Enter with the focus", () => {
    drives();
    const horn = button("Horn");
    send(horn, "pointerdown", { pointerId: 3, button: 2 });
    expect(sent).toEqual([]);
    send(horn, "pointerdown", { pointerId: 3, button: 0 });
    expect(sent.at(-1)?.held).toEqual({ horn: 1 });
    expect(horn.className).toContain("is-held");
    send(horn, "pointerup", { pointerId: 3 });
    expect(sent.at(-1)?.held).toEqual({});
    for (const end of [
      () => send(horn, "keyup", { code: "Space" }),
      () => act(() => void horn.dispatchEvent(new FocusEvent("blur"))),
      () => send(horn, "lostpointercapture", { pointerId: 4 }),
    ]) {
      send(horn, "keydown", { code: "KeyX" });
      send(horn, "keydown", { code: "Space" });
      send(horn, "keydown", { code: "Space", repeat: true });
      send(horn, "pointerdown", { pointerId: 4, button: 0 });
      expect(sent.at(-1)?.held).toEqual({ horn: 1 });
      end();
      send(horn, "keyup", { code: "Space" });
      send(horn, "pointercancel", { pointerId: 4 });
      expect(sent.at(-1)?.held).toEqual({});
    }
    expect(horn.className).not.toContain("is-held");
  });

  it("open no menu and take no focus on touch", () => {
    drives();
    for (const type of ["contextmenu", "mousedown"]) {
      const event = new MouseEvent(type, { bubbles: true, cancelable: true });
      act(() => void button("Horn").dispatchEvent(event));
      expect(event.defaultPrevented).toBe(true);
    }
  });

  it("are released when they vanish from the page", () => {
    drives();
    send(button("Horn"), "keydown", { code: "Enter" });
    act(() => {
      state.hello.value = hello({ viewer: ADA });
    });
    expect(sent.at(-1)?.held).toEqual({});
  });

  it("show a set value at once, then as in the room state", () => {
    drives();
    expect(button("Lamp").getAttribute("aria-pressed")).toBe("false");
    act(() => button("Lamp").click());
    expect(sent.at(-1)?.wanted).toEqual({ lamp: 1 });
    expect(button("Lamp").getAttribute("aria-pressed")).toBe("true");
    act(() => {
      state.room.value = { ...room({ operator: ADA, number: 7 }), controls: { light: 1, dim: 55 } };
    });
    expect(button("red").getAttribute("aria-pressed")).toBe("true");
    expect(slider("Brightness").valueAsNumber).toBe(55);
  });

  it("include choices and sliders", () => {
    drives();
    act(() => button("red").click());
    expect(sent.at(-1)?.wanted).toEqual({ light: 1 });
    vi.advanceTimersByTime(200);
    slide(slider("Brightness"), 60);
    expect(state.wantedControls.value).toEqual({ light: 1, dim: 60 });
    send(slider("Brightness"), "pointerdown", { pointerId: 5 });
    expect(sent.at(-1)?.held).toEqual({});
  });

  it("that move by a slider act only while it is held", () => {
    drives();
    const lift = slider("Lift");
    expect(lift.valueAsNumber).toBe(0);
    send(lift, "keydown", { code: "KeyX" });
    expect(controller.input.isHolding).toBe(false);
    send(lift, "keydown", { code: "ArrowRight" });
    slide(lift, 0.05);
    expect(sent.at(-1)?.held).toEqual({ lift: 0.05 });
    send(lift, "keyup", { code: "ArrowRight" });
    expect(sent.at(-1)?.held).toEqual({});
    send(lift, "keydown", { code: "Home" });
    slide(lift, -1);
    act(() => void lift.dispatchEvent(new FocusEvent("blur")));
    expect(sent.at(-1)?.held).toEqual({});
  });

  it("that move release a key without a code whose keyup never comes", () => {
    drives();
    const lift = slider("Lift");
    send(lift, "keydown", { key: "ArrowRight", metaKey: true });
    expect(controller.input.isHolding).toBe(false);
    send(lift, "keydown", { key: "ArrowRight" });
    slide(lift, 0.05);
    vi.advanceTimersByTime(UNHEARD_MS - 1);
    expect(sent.at(-1)?.held).toEqual({ lift: 0.05 });
    act(() => void vi.advanceTimersByTime(1));
    expect(sent.at(-1)?.held).toEqual({});
  });

  it("that move are disabled while a stop is in force, unlike others", () => {
    drives({ stop: pressedBy("Bob") });
    expect(button("Look around").disabled).toBe(true);
    expect(slider("Lift").disabled).toBe(true);
    expect(button("Horn").disabled).toBe(false);
    expect(button("Lamp").disabled).toBe(false);
  });
});

describe("gauges", () => {
  const HEAT: GaugeInfo = {
    name: "heat",
    label: "Motors",
    unit: "°C",
    min: 0,
    max: 100,
    decimals: 1,
  };

  function tells(robot: Partial<RobotStatus>): void {
    act(() => {
      state.hello.value = hello({ viewer: ADA, gauges: [HEAT] });
      const now = room({ operator: ADA });
      state.room.value = { ...now, robot: { ...now.robot, ...robot } };
    });
  }

  const chips = () => [...body.querySelectorAll(".chip")].map((one) => one.textContent);

  it("show each number with its unit, and nothing over the picture while all is well", () => {
    tells({ gauges: { heat: 41.25 } });
    expect(getByRole(body, "region", { name: "Readings" }).textContent).toContain("Motors41.3 °C");
    expect(body.querySelector("meter")?.getAttribute("value")).toBe("41.25");
    expect(chips()).toEqual([]);
  });

  it("warn over the picture, and say what stops the robot", () => {
    tells({ gauges: { heat: 61 }, beyond: { heat: "warn" } });
    expect(chips()).toEqual(["Motors61.0 °C"]);
    expect(body.querySelector(".gauge.is-warn")?.textContent).toContain("unusual");
    tells({ gauges: {}, beyond: { heat: "stop" } });
    expect(chips()).toEqual(["Motorsunknown"]);
    expect(body.querySelector(".gauge.is-stop")?.textContent).toContain("stops the robot");
  });

  it("are absent if the host has configured none", () => {
    drives();
    expect(queryByRole(body, "region")).toBe(null);
  });
});
