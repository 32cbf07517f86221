/** The whole page with a real state and real input, but no connection, for the tests of its parts. */
import { getByRole } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeAll, beforeEach, vi } from "vitest";
import type { Actions, Session } from "../actions";
import { DIRECTIONS, InputState } from "../drive/inputState";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { History } from "../stats/history";
import { hello, room } from "../testing/messages";
import { App } from "./App";
import { HostPanel, RulesPanel } from "./Panels";
import { WaysPanel } from "./Settings";

export let state: State;
export let actions: Actions;
export let input: InputState;
export const body = document.body;
let levels: number[] = [];

/** Call it once in a file: before each of its tests the page is drawn anew. */
export function drawsPage(): void {
  beforeAll(async () => {
    for (const part of [HostPanel, RulesPanel, WaysPanel]) await part.load();
  });
  beforeEach(draw);
  afterEach(() => {
    act(() => render(null, body));
  });
}

function draw(): void {
  levels = [];
  state = createState(loadPreferences(null));
  const changed = () => {
    state.held.value = new Set(DIRECTIONS.filter((one) => input.holds(one)));
    state.motion.value = input.motion;
    state.isHolding.value = input.isHolding;
  };
  input = new InputState({ changed, deflected: changed });
  actions = {
    start: vi.fn(),
    setSound: vi.fn(),
    setPicture: vi.fn(),
    setSize: vi.fn(),
    setPolicy: vi.fn(),
    setPlayer: vi.fn(),
    setVolume: vi.fn(),
    setMuted: vi.fn(),
    toggleMute: vi.fn(),
    setOutput: vi.fn(),
    setCameras: vi.fn(),
    enlarge: vi.fn(),
    setName: vi.fn(),
    setSpeed: vi.fn(),
    setLanguage: vi.fn(),
    keep: vi.fn(),
    setAxis: vi.fn(),
    recentre: vi.fn(),
    holdControl: vi.fn(),
    releaseControl: vi.fn(),
    slideControl: vi.fn(),
    setControl: vi.fn(),
    toggleControl: vi.fn(),
    setDriving: vi.fn(),
    useGamepad: vi.fn(),
    scan: vi.fn(),
    deflect: (holder, motion) => input.deflect(holder, motion),
    join: vi.fn(),
    leave: vi.fn(),
    stop: vi.fn(),
    releaseStop: vi.fn(),
    answerCall: vi.fn(),
    actAsHost: vi.fn(),
    keepTape: vi.fn(),
    comeBack: vi.fn(),
    open(panel) {
      state.panel.value = panel;
    },
    lookAtProof: vi.fn(),
    prove: vi.fn(),
    speak: vi.fn(),
    hush: vi.fn(),
    keepSpeaking: vi.fn(),
    press: (holder, held) => input.press(holder, held),
    release: (holder) => input.release(holder),
    letGo: vi.fn(() => input.releaseAll()),
  };
  const session: Session = {
    state,
    actions,
    attachPicture: vi.fn(),
    attachSound: vi.fn(),
    pictureStream: () => null,
    history: new History(),
    offered: Promise.resolve(),
    shownPicture: () => null,
    soundLevels: async () => levels,
    attachCamera: vi.fn(),
  };
  act(() => render(<App session={session} />, body));
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

export function button(name: string | RegExp): HTMLButtonElement {
  return getByRole(body, "button", { name });
}

/** Opens a panel by its tab. */
export function open(tab: string): void {
  act(() => button(tab).click());
}

/** What a pointer does to an element; its captures are returned. */
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

export function key(element: Element, type: string, code: string): void {
  act(() => {
    element.dispatchEvent(new KeyboardEvent(type, { code, bubbles: true, cancelable: true }));
  });
}

/** Shows the page of a host, with what the server tells only them. */
export function showHost(options: Parameters<typeof room>[0] = { watching: [1] }): void {
  show(options);
  act(() => {
    state.hello.value = hello({ viewer: 1, is_host: true });
    state.console.value = { type: "console", viewers: [], closed: false, opens_wall_ms: null };
    state.panel.value = "host";
  });
}
