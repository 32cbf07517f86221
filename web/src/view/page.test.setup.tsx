/** The whole page with real state and input but without a connection, for tests of its parts. */
import { getByRole } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeAll, beforeEach, vi } from "vitest";
import type { Actions } from "../actions";
import { DIRECTIONS, InputState } from "../drive/inputState";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { undraw } from "../testing/draw";
import { hello, hostConsole, planar, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { App } from "./App";
import { Facts, HostPanel, RulesPanel } from "./Panels";
import { Watching, WaysPanel } from "./Settings";
import { WatchActs } from "./Watching";

export let state: State;
export let actions: Actions;
export let input: InputState;
export const body = document.body;
let levels: number[] = [];

/** Call it once per file: it draws the page anew before each test. */
export function drawsPage(): void {
  beforeAll(async () => {
    for (const part of [Facts, HostPanel, RulesPanel, Watching, WatchActs, WaysPanel])
      await part.load();
  });
  beforeEach(draw);
  afterEach(undraw);
}

function draw(): void {
  levels = [];
  state = createState(loadPreferences(null));
  input = inputTo(state);
  const session = testSession(state);
  const real: Partial<Actions> = {
    deflect: (holder, motion) => input.deflect(holder, motion),
    press: (holder, held) => input.press(holder, held),
    release: (holder) => input.release(holder),
    letGo: vi.fn(() => input.releaseAll()),
    open(panel) {
      state.panel.value = panel;
    },
  };
  const get = (own: Actions, name: keyof Actions) => real[name] ?? own[name];
  actions = new Proxy(session.actions, { get } as ProxyHandler<Actions>);
  const whole = { ...session, actions, soundLevels: async () => levels };
  act(() => render(<App session={whole} />, body));
}

/** Real input, connected to this state. */
export function inputTo(state: State): InputState {
  const changed = () => {
    state.held.value = new Set(DIRECTIONS.filter((one) => made.holds(one)));
    state.motion.value = made.motion;
    state.isHolding.value = made.isHolding;
  };
  const made = new InputState({
    changed,
    deflected: changed,
    movesSideways: () => state.movesSideways.peek(),
  });
  return made;
}

/** What the sound meter reads from now on. */
export function hears(found: number[]): void {
  levels = found;
}

export function show(options: Parameters<typeof room>[0], axes: string[] = []): void {
  act(() => {
    const mine = hello({ viewer: 1 });
    state.hello.value = { ...mine, robot: { ...mine.robot, axes } };
    state.room.value = room(options);
    state.link.value = { is: "connected" };
    state.serverMs.value = 18_000;
    if (state.mayMove.value) input.enable();
    else input.disable();
  });
}

/** The robot also moves sideways from now on. */
export function movesSideways(): void {
  act(() => {
    const { hello: greeting } = state;
    if (greeting.value) greeting.value = planar(greeting.value);
  });
}

export function button(name: string | RegExp): HTMLButtonElement {
  return getByRole(body, "button", { name });
}

/** Opens a panel by its tab. */
export function open(tab: string): void {
  act(() => button(tab).click());
}

/** Dispatches a pointer event to an element; returns its captures. */
export function pointer(element: Element, type: string, pointerId = 1) {
  const capture = vi.fn<(pointerId: number) => void>();
  element.setPointerCapture = capture;
  act(() => {
    element.dispatchEvent(
      new PointerEvent(type, { bubbles: true, cancelable: true, pointerId, button: 0 }),
    );
  });
  return capture;
}

export function key(element: Element, type: string, code: string, more: KeyboardEventInit = {}) {
  act(() => {
    const told = { code, bubbles: true, cancelable: true, ...more };
    element.dispatchEvent(new KeyboardEvent(type, told));
  });
}

/** Shows a host's page, with the messages that only hosts get. */
export function showHost(options: Parameters<typeof room>[0] = { watching: [1] }): void {
  show(options);
  act(() => {
    state.hello.value = hello({ viewer: 1, is_host: true });
    state.console.value = hostConsole();
    state.panel.value = "host";
  });
}
