// @vitest-environment happy-dom
import {
  getAllByRole,
  getAllByText,
  getByRole,
  getByText,
  queryByRole,
  queryByText,
} from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import type { Actions, Session } from "../actions";
import { DIRECTIONS, type Direction, fingerHolder, InputState } from "../drive/inputState";
import { listenKeyboard } from "../drive/keyboard";
import { DEFAULT_KEYS } from "../drive/keyMap";
import type { Tape, VoiceInfo } from "../messages";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { History } from "../stats/history";
import { aboard, hello, playout, room, served } from "../testing/messages";
import { says } from "../words/said";
import { App } from "./App";
import { HostPanel, RulesPanel } from "./Panels";
import { WaysPanel } from "./Settings";
import { blanked, notInvited, released } from "./words";

let state: State;
let actions: Actions;
let levels: number[] = [];
let input: InputState;
let body: HTMLElement;

/** The page with a real state and real input, but no connection. */
beforeAll(async () => {
  for (const part of [HostPanel, RulesPanel, WaysPanel]) await part.load();
});

beforeEach(() => {
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
  body = document.body;
  act(() => render(<App session={session} />, body));
});

afterEach(() => {
  act(() => render(null, body));
});

function show(options: Parameters<typeof room>[0], axes: string[] = []): void {
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

function button(name: string | RegExp): HTMLButtonElement {
  return getByRole(body, "button", { name });
}

/** Opens a panel by its tab. */
function open(tab: string): void {
  act(() => button(tab).click());
}

/** What a pointer does to an element; its captures are returned. */
function pointer(element: Element, type: string, pointerId = 1) {
  const capture = vi.fn<(pointerId: number) => void>();
  element.setPointerCapture = capture;
  act(() => {
    element.dispatchEvent(
      new PointerEvent(type, { bubbles: true, cancelable: true, pointerId, button: 0 }),
    );
  });
  return capture;
}

function key(element: Element, type: string, code: string): void {
  act(() => {
    element.dispatchEvent(new KeyboardEvent(type, { code, bubbles: true, cancelable: true }));
  });
}

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

  it("offers who only watches nothing to drive with", () => {
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

  it("goes on by the arrow keys when Slow or Fast has the focus", () => {
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

  it("is said to be nearly over to who hears, once", () => {
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
      state.link.value = { is: "waiting", retryAtMs: 3000, reason: "The server is gone." };
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

  it.each(["pointercancel", "lostpointercapture"])("lets go of everything on %s", (type) => {
    show({ operator: 1 });
    pointer(button("Forward"), "pointerdown", 1);
    pointer(button("Left"), "pointerdown", 2);
    pointer(button("Forward"), type, 1);
    expect(actions.letGo).toHaveBeenCalled();
    expect(input.motion).toEqual({ linear: 0, angular: 0 });
  });

  it.each(["Space", "Enter"])("works by holding %s on a button that has the focus", (code) => {
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

  it("says why the robot stands", () => {
    show({ operator: 1 });
    act(() => {
      state.driveReason.value = { code: "drive.too_old" };
    });
    expect(getByText(body, "No fresh commands arrive: your connection is slow.")).toBeTruthy();
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

  it("takes a slider that is held for a control that is held", () => {
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

describe("Stop", () => {
  it("acts at once when it is touched, and not again when the touch ends", () => {
    show({ operator: 1 });
    pointer(button("Stop"), "pointerdown");
    expect(actions.stop).toHaveBeenCalledOnce();
    pointer(button("Stop"), "pointerup");
    button("Stop").dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 1 }));
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it.each(["Space", "Enter"])("acts at once by %s, while it has the focus", (code) => {
    show({ watching: [1] });
    key(button("Stop"), "keydown", code);
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it("acts by a press that is neither finger nor key", () => {
    show({ watching: [1] });
    button("Stop").click();
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it.each([
    ["watches", { operator: 2, watching: [1] }],
    ["waits", { operator: 2, waiting: [1] }],
    ["drives", { operator: 1 }],
  ])("is there for who %s, with or without a connection", (_, options) => {
    show(options);
    expect(button("Stop").disabled).toBe(false);
    act(() => {
      state.link.value = { is: "connecting", reason: null };
    });
    expect(button("Stop").disabled).toBe(false);
  });

  it("is the operator's and the host's alone where the server says so", () => {
    show({ operator: 2, watching: [1] });
    const on_loss = { ...hello().on_loss, stop_by: "operator" as const };
    act(() => {
      state.hello.value = hello({ viewer: 1, on_loss });
    });
    expect(button("Stop").disabled).toBe(true);
    act(() => {
      state.room.value = room({ operator: 1 });
    });
    expect(button("Stop").disabled).toBe(false);
    act(() => {
      state.room.value = room({ operator: 2, watching: [1] });
      state.hello.value = hello({ viewer: 1, on_loss, is_host: true });
    });
    expect(button("Stop").disabled).toBe(false);
  });
});

describe("a stop that is latched", () => {
  const stop = { number: 7, by: says("Cleo"), viewer: null };
  const release = () => queryByRole(body, "button", { name: "Hold to release" });

  beforeEach(() => {
    vi.useFakeTimers();
  });

  afterEach(() => {
    vi.useRealTimers();
  });

  function wait(ms: number): void {
    act(() => {
      vi.advanceTimersByTime(ms);
    });
  }

  it("is told to everybody, with who pressed it and what ends it", () => {
    show({ operator: 2, watching: [1], stop });
    const words = getByText(body, "Stopped by Cleo").parentElement;
    expect(words?.getAttribute("aria-live")).toBe("assertive");
    expect(words?.textContent).toContain("Nothing moves until Bob or the host releases it.");
    expect(release()).toBeNull();
    show({ operator: 2, watching: [1] });
    expect(queryByText(body, "Stopped by Cleo")).toBeNull();
  });

  it("takes the drive buttons away, and gives them back empty", () => {
    show({ operator: 1 });
    pointer(button("Forward"), "pointerdown");
    show({ operator: 1, stop });
    expect(input.isHolding).toBe(false);
    expect(button("Forward").disabled).toBe(true);
    expect(button("Stop").disabled).toBe(false);
    show({ operator: 1 });
    expect(button("Forward").disabled).toBe(false);
    expect(input.isHolding).toBe(false);
  });

  it("is released by a hold of 0.8 s, and by nothing shorter", () => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    wait(700);
    pointer(button("Hold to release"), "pointerup");
    wait(1000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
    pointer(button("Hold to release"), "pointerdown");
    wait(900);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
    wait(2000);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
  });

  it.each(["pointercancel", "lostpointercapture", "blur"])("is not released after %s", (type) => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    pointer(button("Hold to release"), type);
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
  });

  it("keeps a finger that holds it when the page moves under it", () => {
    show({ operator: 1, stop });
    const capture = pointer(button("Hold to release"), "pointerdown", 7);
    expect(capture).toHaveBeenCalledExactlyOnceWith(7);
  });

  it("is not released when the window goes away meanwhile", () => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    act(() => void window.dispatchEvent(new Event("blur")));
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
  });

  it("is released by holding Enter, and never by Space or a click", () => {
    show({ operator: 1, stop });
    key(button("Hold to release"), "keydown", "Space");
    wait(2000);
    key(button("Hold to release"), "keyup", "Space");
    button("Hold to release").click();
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
    key(button("Hold to release"), "keydown", "Enter");
    wait(900);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
  });

  it("is released by the host too, who need not drive", () => {
    show({ operator: 2, watching: [1], stop });
    act(() => {
      state.hello.value = hello({ viewer: 1, is_host: true });
    });
    expect(release()).not.toBeNull();
  });

  it("asks the operator to press anew once it is released, until they do", () => {
    show({ operator: 1 });
    act(() => {
      state.isFreshlyReleased.value = true;
    });
    expect(getByText(body, released())).toBeTruthy();
    act(() => {
      state.driveReason.value = says("Slow: the link is late.");
    });
    expect(queryByText(body, released())).toBeNull();
    expect(getByText(body, "Slow: the link is late.")).toBeTruthy();
  });
});

describe("what is disclosed", () => {
  it("is there for everybody, and nothing of it can be changed", () => {
    show({ watching: [1] });
    open("Safety");
    const panel = getByText(body, /150 ms/).closest("ul");
    expect(panel?.textContent).toContain("150 ms");
    expect(panel?.querySelector("input, select, button")).toBeNull();
  });
});

/** Shows the page of a host, with what the server tells only them. */
function showHost(options: Parameters<typeof room>[0] = { watching: [1] }): void {
  show(options);
  act(() => {
    state.hello.value = hello({ viewer: 1, is_host: true });
    state.console.value = { type: "console", viewers: [], closed: false, opens_wall_ms: null };
    state.panel.value = "host";
  });
}

describe("the host's panel", () => {
  const panel = () => body.querySelector(".host") as HTMLElement;
  const within = (name: string) => getByRole(panel(), "button", { name });
  const line = { id: 2, address: "192.0.2.0/24", invited: true, muted: false };
  const asked = (...acts: object[]) => {
    for (const one of acts) expect(actions.actAsHost).toHaveBeenCalledWith(one);
    expect(actions.actAsHost).toHaveBeenCalledTimes(acts.length);
  };

  function showPeople(): void {
    showHost({ operator: 2, watching: [1] });
    act(() => {
      const now = room({ operator: 2, watching: [1] });
      for (const one of now.viewers) one.host = one.id === 1;
      state.room.value = now;
      state.console.value = {
        type: "console",
        viewers: [{ ...line, round_trip_ms: 42, picture_ms: 80, rendition: "640x480" }],
        closed: false,
        opens_wall_ms: null,
      };
    });
  }

  it("is the host's alone", () => {
    show({ watching: [1] });
    expect(queryByRole(body, "button", { name: "Host" })).toBeNull();
    act(() => {
      state.panel.value = "host";
    });
    expect(panel()).toBeNull();
    showHost();
    expect(panel()).toBeTruthy();
  });

  it("tells who is here, and how they are connected", () => {
    showPeople();
    const people = getByRole(panel(), "list").textContent;
    expect(people).toContain("Bob drivinginvited");
    expect(people).toContain("192.0.2.0/24 · 42 ms there and back");
    expect(people).toContain("Ada watchinghost");
  });

  it("offers nothing against a host", () => {
    showPeople();
    expect(getAllByRole(panel(), "button", { name: "Remove…" })).toHaveLength(1);
  });

  it("asks once before it removes somebody, and takes no for an answer", () => {
    showPeople();
    act(() => within("Remove…").click());
    expect(getByRole(panel(), "alert").textContent).toBe("Remove Bob?");
    act(() => within("Cancel").click());
    expect(actions.actAsHost).not.toHaveBeenCalled();
    act(() => within("Remove…").click());
    act(() => within("Remove").click());
    act(() => within("Remove…").click());
    act(() => within("Remove and keep out for a day").click());
    asked({ type: "remove", viewer: 2, ban: false }, { type: "remove", viewer: 2, ban: true });
  });

  it("mutes a Stop, pauses the queue and ends this turn, no other", () => {
    showPeople();
    act(() => within("Mute their Stop").click());
    act(() => getByRole(panel(), "switch", { name: "Pause the queue" }).click());
    act(() => within("End this turn…").click());
    act(() => within("End it").click());
    asked(
      { type: "mute", viewer: 2, muted: true },
      { type: "hold_queue", held: true },
      { type: "end_turn", turn: 1 },
    );
  });

  it("asks before it closes; locks, and shows or hides the picture, at one press", () => {
    showHost();
    act(() => within("Only invited people").click());
    act(() => within("Close for today…").click());
    act(() => within("Close").click());
    act(() => getByRole(panel(), "switch", { name: /Picture and sound off/ }).click());
    asked(
      { type: "lock", locked: true },
      { type: "close", closed: true },
      { type: "blank", blanked: true },
    );
  });

  it("opens again what is closed", () => {
    showHost();
    act(() => {
      const now = room({ watching: [1] });
      now.house.locked = true;
      state.room.value = now;
      state.console.value = { type: "console", viewers: [], closed: true, opens_wall_ms: null };
    });
    act(() => within("Let strangers in again").click());
    act(() => within("Open").click());
    asked({ type: "lock", locked: false }, { type: "close", closed: false });
  });

  it.each([
    ["", window.location.origin],
    ["https://robot.example.org", "https://robot.example.org"],
  ])("makes an invitation as it was chosen, and shows its link (%s)", (page, origin) => {
    showHost();
    act(() => within("Make a link").click());
    asked({ type: "invite", purpose: "queue", uses: 1, valid_s: 86_400 });
    act(() => {
      state.invitation.value = {
        type: "invitation",
        page,
        token: "tok",
        purpose: "queue",
        uses: 1,
        ends_wall_ms: Date.now() + 3_600_000,
      };
    });
    const field = getByRole<HTMLInputElement>(panel(), "textbox", { name: "Invitation link" });
    expect(field.value).toBe(`${origin}/#invite=tok`);
  });

  it("limits the guests' speed", () => {
    showHost();
    const select = getByRole<HTMLSelectElement>(panel(), "combobox", { name: /Guests drive/ });
    act(() => {
      select.value = "0.5";
      select.dispatchEvent(new Event("change", { bubbles: true }));
    });
    asked({ type: "limit_speed", fraction: 0.5 });
  });

  it("shows a message to all, and takes it away", () => {
    showHost();
    const field = getByRole<HTMLInputElement>(panel(), "textbox", { name: "Message to all" });
    act(() => {
      field.value = " Tea! ";
      field.dispatchEvent(new Event("input", { bubbles: true }));
    });
    act(() => within("Show").click());
    act(() => {
      const now = room({ watching: [1] });
      now.house.message = "Tea!";
      state.room.value = now;
    });
    act(() => within("Take it away").click());
    asked({ type: "announce", text: "Tea!" }, { type: "announce", text: "" });
    expect(getByText(body, "The host says:").parentElement?.textContent).toContain("Tea!");
  });
});

describe("a person aboard", () => {
  const driving = "The person aboard is driving: advise them until they let go.";
  function sits(
    more: Parameters<typeof aboard>[0],
    asked: "left" | null = null,
    operator = 2,
  ): void {
    const now = operator === 1 ? { operator } : { operator, watching: [1] };
    show(now);
    act(() => {
      state.room.value = { ...room(now), aboard: aboard(more) };
      state.request.value = asked && { asked };
    });
  }

  it("is not spoken of while an operator may drive", () => {
    sits({});
    expect(body.querySelector(".banners")?.textContent).toBe("");
  });

  it("drives, and everybody reads why nobody else does", () => {
    sits({ mode: "hand", reason: says(driving) });
    expect(getByText(body, driving)).toBeTruthy();
  });

  it("drives, which the operator reads beside their controls and only there", () => {
    sits({ mode: "hand", reason: says(driving) }, null, 1);
    act(() => {
      state.driveReason.value = says(driving);
    });
    expect(getByText(body, driving).closest(".banners")).toBeNull();
  });

  it("asks, and it is read out at once", () => {
    sits({ asked: "left", asks: 1 }, "left");
    expect(getByRole(body, "alert").textContent).toBe("From aboard: To the left, please.");
  });

  it("has no control that answers, which is the robot's problem and said once", () => {
    sits({ mode: "lost", reason: says("The hand control of the person aboard does not answer") });
    expect(body.querySelector(".banners")?.textContent).toBe("");
  });
});

describe("a call", () => {
  function call(viewer = 1): void {
    show({ operator: 2, waiting: [1] });
    act(() => {
      const now = room({ operator: 2, waiting: [1] });
      state.room.value = { ...now, call: { viewer, until_server_ms: 28_000 } };
    });
  }
  const card = () => queryByRole(body, "alertdialog");

  it("asks the next one, with the time left, and changes the title", () => {
    call();
    expect(card()?.textContent).toContain("Your turn is next. Are you ready?");
    expect(card()?.textContent).toContain("10 s left");
    expect(document.title).toContain("Are you ready?");
    show({ operator: 1 });
    expect(card()).toBeNull();
    expect(document.title).toContain("You are driving");
  });

  it("shakes a phone that can be, once when it comes and once when one may drive", () => {
    const vibrate = vi.fn(() => true);
    Object.defineProperty(navigator, "vibrate", { value: vibrate, configurable: true });
    call();
    expect(vibrate).toHaveBeenCalledExactlyOnceWith([200, 100, 200]);
    act(() => {
      state.serverMs.value = 19_000;
    });
    expect(vibrate).toHaveBeenCalledOnce();
    show({ operator: 1 });
    expect(vibrate).toHaveBeenCalledTimes(2);
    Reflect.deleteProperty(navigator, "vibrate");
  });

  it("takes the keyboard from where one reads, not from a control", () => {
    const turn = getByRole(body, "region", { name: "Turn" });
    turn.tabIndex = -1;
    turn.focus();
    call();
    expect(document.activeElement).toBe(button("I am ready"));
    show({ operator: 1 });
    button("Settings").focus();
    call();
    expect(document.activeElement).toBe(button("Settings"));
  });

  it("is for nobody else", () => {
    call(3);
    expect(card()).toBeNull();
  });

  it("is answered by a touch anywhere on it, once", () => {
    call();
    act(() => card()?.click());
    expect(actions.answerCall).toHaveBeenCalledOnce();
  });

  it("is answered by its button, once, and by any key on it but Tab", () => {
    call();
    expect(document.activeElement).toBe(button("I am ready"));
    act(() => button("I am ready").click());
    expect(actions.answerCall).toHaveBeenCalledOnce();
    button("I am ready").dispatchEvent(new KeyboardEvent("keydown", { key: "Tab" }));
    expect(actions.answerCall).toHaveBeenCalledOnce();
    button("I am ready").dispatchEvent(new KeyboardEvent("keydown", { key: "x" }));
    expect(actions.answerCall).toHaveBeenCalledTimes(2);
  });

  it("takes the keyboard from nobody who types", () => {
    show({ operator: 2, waiting: [1] });
    const field = getByRole(body, "textbox", { name: "Your name" });
    field.focus();
    call();
    expect(document.activeElement).toBe(field);
  });

  it("that was missed is told of", () => {
    show({ operator: 2, waiting: [1] });
    act(() => {
      state.missedCall.value = "kept";
    });
    expect(getByText(body, /Your place is kept this once/)).toBeTruthy();
  });
});

describe("who may not stay, hear or drive", () => {
  it("reads why, and when the robot opens, and may try again", () => {
    show({ watching: [1] });
    act(() => {
      state.ended.value = {
        type: "ended",
        text: says("The robot is closed."),
        opens_wall_ms: Date.now() + 86_400_000,
      };
    });
    expect(getByRole(body, "heading", { name: "The robot is closed." })).toBeTruthy();
    expect(getByText(body, /It opens tomorrow at/)).toBeTruthy();
    expect(queryByRole(body, "button", { name: "Stop" })).toBeNull();
    act(() => button("Try again").click());
    expect(actions.comeBack).toHaveBeenCalledOnce();
  });

  it("reads what is wrong with the link that brought them, until they have read it", () => {
    show({ watching: [1] });
    act(() => {
      state.entryProblem.value = "This invitation is used up; ask the host for a new one.";
    });
    expect(getByText(body, /used up/)).toBeTruthy();
    act(() => button("OK").click());
    expect(queryByText(body, /used up/)).toBeNull();
  });

  it("reads why it takes a while before the first connection", () => {
    act(() => {
      state.link.value = { is: "waiting", retryAtMs: 5000, reason: "All 100 places are taken." };
    });
    expect(getByText(body, "All 100 places are taken.")).toBeTruthy();
    expect(getByText(body, "This page tries again by itself.")).toBeTruthy();
  });

  it("is offered neither queue nor sound that are for the invited", () => {
    show({ operator: 2, watching: [1] });
    act(() => {
      state.hello.value = hello({ viewer: 1, may_queue: false, may_hear: false });
    });
    expect(queryByRole(body, "button", { name: "Join the queue" })).toBeNull();
    expect(queryByRole(body, "switch", { name: "Sound" })).toBeNull();
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
    expect(getAllByText(body, notInvited()).length).toBeGreaterThan(0);
  });

  it("sees a card in the place of a picture that the host has switched off", () => {
    show({ watching: [1] });
    act(() => {
      const now = room({ watching: [1] });
      now.house.blanked = true;
      state.room.value = now;
    });
    expect(getByText(body, blanked())).toBeTruthy();
    expect(body.querySelector("video")?.classList.contains("is-off")).toBe(true);
  });
});

describe("the proof of the stop", () => {
  it("is the host's", () => {
    show({ watching: [1] });
    expect(queryByText(body, "Prove the stop…")).toBeNull();
    showHost();
    expect(getByText(body, "Prove the stop…")).toBeTruthy();
  });

  it("starts only after the word that the wheels are off the floor, anew for each", () => {
    showHost();
    const box = getByRole<HTMLInputElement>(body, "checkbox", {
      name: "The wheels are off the floor",
    });
    button("Prove it now").click();
    expect(actions.prove).not.toHaveBeenCalled();
    act(() => box.click());
    act(() => button("Prove it now").click());
    expect(actions.prove).toHaveBeenCalledOnce();
    expect(box.checked).toBe(false);
    expect(button("Prove it now").disabled).toBe(true);
  });

  it("shows how far it is, and where its record lies", () => {
    showHost();
    act(() => {
      state.proof.value = {
        state: "running",
        line: says("The page is closed (3 of 40)"),
        record: null,
      };
    });
    expect(getByRole(body, "status", { name: "Proof" }).textContent).toContain("3 of 40");
    expect(getByRole<HTMLInputElement>(body, "checkbox").disabled).toBe(true);
    act(() => {
      state.proof.value = { state: "done", line: says("In time."), record: "/api/proof/record" };
    });
    const link = getByRole(body, "link", { name: "Open the record" });
    expect(link.getAttribute("href")).toBe("/api/proof/record");
  });
});

describe("the queue", () => {
  it("leaves a name alone while it is typed, whatever happens in the room", () => {
    show({ watching: [1] });
    const field = getByRole(body, "textbox", { name: "Your name" }) as HTMLInputElement;
    field.value = "Ad";
    act(() => void field.dispatchEvent(new Event("input", { bubbles: true })));
    show({ operator: 2, watching: [1] });
    expect(field.value).toBe("Ad");
    field.value = "Ada";
    act(() => void field.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setName).toHaveBeenCalledWith("Ada");
  });

  it("lists everybody in order and marks oneself", () => {
    show({ operator: 2, waiting: [1], watching: [3] });
    const lines = [...getByRole(body, "list", { name: "Queue" }).children];
    expect(lines.map((line) => line.textContent)).toEqual([
      "Bob driving",
      "Ada (you) next, about 30 s",
      "Cleo watching",
    ]);
  });

  it("shows a name as text", () => {
    show({ watching: [1] });
    act(() => {
      const now = room({ watching: [1] });
      for (const viewer of now.viewers) viewer.name = "<img src=x>";
      state.room.value = now;
    });
    expect(getByText(body, "<img src=x>")).toBeTruthy();
    expect(body.querySelector("img")).toBeNull();
  });

  it("tells who waits how long, in the clock, which is not read out by itself", () => {
    show({ operator: 2, waiting: [1] });
    expect(getByRole(body, "timer", { name: "Until your turn" }).textContent).toBe("about 30 s");
    expect(button("Leave the queue")).toBeTruthy();
  });

  it("is joined and left by a click, but not both by a double click", () => {
    show({ watching: [1] });
    button("Join the queue").click();
    expect(actions.join).toHaveBeenCalledOnce();
    show({ operator: 1 });
    const leave = button("End my turn");
    leave.dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 2 }));
    expect(actions.leave).not.toHaveBeenCalled();
    leave.dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 1 }));
    expect(actions.leave).toHaveBeenCalledOnce();
  });
});

describe("sound and picture", () => {
  it("offers sound until the sound was decided on", () => {
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeTruthy();
    button("Turn sound on").click();
    expect(actions.start).toHaveBeenCalledOnce();
    act(() => {
      state.isStartOffered.value = false;
    });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
  });

  it("offers no sound where there is nothing to hear", () => {
    show({ watching: [1] });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeTruthy();
    act(() => {
      state.hello.value = hello({ viewer: 1, has_microphone: false });
    });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
    expect(queryByRole(body, "switch", { name: "Sound" })).toBeNull();
    open("Settings");
    expect(body.textContent).toContain("This robot has no microphone.");
  });

  it("switches each by itself", () => {
    show({ watching: [1] });
    const sound = getByRole(body, "switch", { name: "Sound" });
    expect(sound.getAttribute("aria-checked")).toBe("false");
    sound.click();
    expect(actions.setSound).toHaveBeenCalledWith(true);
    open("Settings");
    const picture = getByRole(body, "switch", { name: "Picture" });
    expect(picture.getAttribute("aria-checked")).toBe("true");
    picture.click();
    expect(actions.setPicture).toHaveBeenCalledWith(false);
  });

  function choose(name: string, value: string): void {
    const select = getByRole<HTMLSelectElement>(body, "combobox", { name });
    act(() => {
      select.value = value;
      select.dispatchEvent(new Event("change", { bubbles: true }));
    });
  }

  it("bounds the picture's size", () => {
    show({ watching: [1] });
    open("Settings");
    const select = getByRole(body, "combobox", { name: "Picture size" });
    const options = [...select.children].map((one) => one.textContent);
    expect(options).toEqual(["Largest, 640 × 480", "Up to 320 × 240"]);
    choose("Picture size", "320x240");
    expect(actions.setSize).toHaveBeenCalledWith("320x240");
  });

  it("offers no choice where one policy holds for everybody", () => {
    show({ watching: [1] });
    open("Settings");
    act(() => {
      state.playout.value = playout({ policy: "thesis" });
    });
    expect(getByRole(body, "combobox", { name: "Picture size" })).toBeTruthy();
    expect(queryByRole(body, "radio", { name: "Immediate" })).toBeNull();
  });

  it("says quietly that the link cannot carry both in step, for as long as that is so", () => {
    const words = "Your connection is slow: picture and sound play as soon as they arrive.";
    show({ watching: [1] });
    act(() => {
      state.served.value = served({ in_step: false });
    });
    expect(getByText(body, words)).toBeTruthy();
    act(() => {
      state.served.value = served();
    });
    expect(queryByText(body, words)).toBeNull();
  });

  it("says calmly that the picture is off", () => {
    show({ watching: [1] });
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
    });
    expect(getByText(body, "The picture is off.")).toBeTruthy();
  });

  it("shows what is wrong with robot, camera and microphone", () => {
    show({ watching: [1] });
    act(() => {
      state.room.value = {
        ...room({ watching: [1] }),
        video: { problem: says("it was unplugged") },
      };
    });
    expect(getByText(body, "Camera: it was unplugged")).toBeTruthy();
  });
});

describe("the level of the sound", () => {
  beforeEach(() => vi.useFakeTimers());
  afterEach(() => vi.useRealTimers());

  const shown = async (channels: number, found: number[]) => {
    levels = found;
    show({ watching: [1] });
    act(() => {
      state.served.value = served({ sound_channels: channels });
      state.isSoundOn.value = true;
    });
    await act(async () => {
      await vi.advanceTimersByTimeAsync(250);
    });
    return [...body.querySelectorAll<HTMLMeterElement>(".sound-meter:not(.is-off) meter")].map(
      (one) => [one.getAttribute("aria-label"), one.value],
    );
  };

  it("is of two ears where there are two", async () => {
    expect(await shown(2, [0.5, 0.25])).toEqual([
      ["Sound level, left", 0.5],
      ["Sound level, right", 0.25],
    ]);
  });

  it("is one where the sound is mono, or the player does not tell them apart", async () => {
    expect(await shown(1, [0.5, 0.5])).toEqual([["Sound level", 0.5]]);
    expect(await shown(2, [0.25])).toEqual([["Sound level", 0.25]]);
  });

  it("is not shown where nobody knows it, or the sound is off", async () => {
    expect(await shown(2, [])).toEqual([]);
    await shown(2, [0.5, 0.5]);
    act(() => {
      state.isSoundOn.value = false;
    });
    expect(body.querySelector(".sound-meter:not(.is-off)")).toBeNull();
  });
});

describe("a picture that is not live", () => {
  const NOT_LIVE = "Not live: the server is not answering.";
  const isGrey = () =>
    getByRole(body, "region", { name: "Picture" }).classList.contains("is-greyed");

  it("is grey while the server does not answer, and the page says for how long", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 46 };
    });
    expect(isGrey()).toBe(false);
    act(() => {
      state.link.value = { is: "silent", sinceMs: 1000 };
      state.pageMs.value = 3200;
    });
    expect(isGrey()).toBe(true);
    expect(getByRole(body, "status").textContent).toBe("No answer for 2 s");
    expect(getByText(body, NOT_LIVE)).toBeTruthy();
    expect(button(/^Delay/).textContent).toBe("Delay–");
    act(() => {
      state.link.value = { is: "connected" };
    });
    expect(isGrey()).toBe(false);
    expect(queryByText(body, NOT_LIVE)).toBeNull();
  });

  it("is grey when it has stood for long over a link that lives", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
    });
    expect(isGrey()).toBe(true);
    expect(getByText(body, "The picture is 1700 ms old.")).toBeTruthy();
  });

  it("is not read out again with each new figure of its age, or second without an answer", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
    });
    expect(getByText(body, "The picture is 1700 ms old.").getAttribute("aria-hidden")).toBe("true");
    expect(getByText(body, "The picture is not live.").closest("[aria-live=polite]")).toBeTruthy();
    act(() => {
      state.link.value = { is: "waiting", retryAtMs: 3000, reason: "The server is gone." };
    });
    expect(getByRole(body, "status").getAttribute("aria-live")).toBe("off");
    const told = getByText(body, "Reconnecting… The server is gone.");
    expect(told.getAttribute("aria-live")).toBe("polite");
    act(() => {
      state.link.value = { is: "connecting", reason: "The server is gone." };
    });
    expect(getByRole(body, "status").getAttribute("aria-live")).toBe("off");
    expect(told.textContent).toBe("Reconnecting… The server is gone.");
  });

  it("is spoken of once only", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
      state.link.value = { is: "silent", sinceMs: 0 };
    });
    expect(getByText(body, NOT_LIVE)).toBeTruthy();
    expect(queryByText(body, "The picture is 1700 ms old.")).toBeNull();
  });

  it("is not spoken of where the picture is off", () => {
    show({ watching: [1] });
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
      state.link.value = { is: "silent", sinceMs: 0 };
    });
    expect(queryByText(body, NOT_LIVE)).toBeNull();
    expect(getByRole(body, "status").textContent).toContain("No answer");
  });
});

it("says how many watch where they are too many to name", () => {
  show({ watching: [1] });
  expect(queryByText(body, /people watch/)).toBeNull();
  act(() => {
    state.watching.value = 12_345;
  });
  expect(getByText(body, "12,345 people watch.")).toBeTruthy();
});

it("names the pages of others while there is no place here", () => {
  const url = "https://watch.example.org/robot";
  act(() => {
    state.links.value = [url];
    state.link.value = { is: "waiting", retryAtMs: 5000, reason: "Watching is full." };
  });
  expect(getByRole(body, "link", { name: url }).getAttribute("href")).toBe(url);
  act(() => {
    state.link.value = { is: "connected" };
  });
  expect(queryByRole(body, "link", { name: url })).toBeNull();
});

it("does not take a page for the operator's that watches elsewhere", () => {
  show({ operator: 1 });
  expect(state.mayMove.value).toBe(true);
  act(() => {
    state.isElsewhere.value = true;
  });
  expect(state.mayMove.value).toBe(false);
});

it("shows how well it plays, what is sent and why", () => {
  show({ watching: [1] });
  act(() => {
    state.facts.value = {
      pictureMs: 46.2,
      pictureErrorMs: 2.4,
      soundMs: 80,
      skewMs: 33.8,
      roundTripMs: 12,
      jitterMs: 2,
      bufferMs: 30,
      arrivedFps: 25,
      fps: 25,
      pauses: { count: 0, longestMs: 0 },
      freezes: { count: 1, longestMs: 410 },
    };
    state.served.value = served();
    state.playout.value = playout();
  });
  const told = (name: string) => getByText(body, name).nextElementSibling?.textContent;
  expect(button(/^Delay/).textContent).toBe("Delay46 ms");
  act(() => button(/^Delay/).click());
  expect(told("Picture age")).toBe("46 ms ± 3");
  expect(told("Not included")).toContain("camera");
  expect(told("Sound age")).toBe("80 ms");
  expect(told("Skew")).toBe("sound 34 ms later");
  expect(told("Sound gaps, last minute")).toBe("none");
  expect(told("Freezes, last minute")).toBe("1, longest 410 ms");
  expect(told("Playback")).toBe("Smooth");
  expect(told("Picture sent")).toContain("640 × 480");
  expect(told("Sound sent")).toContain("20 ms packets");
  expect(told("Link")).toContain("2.4 Mbit/s");
  expect(getByText(body, "as large as asked for")).toBeTruthy();
  expect(getByText(body, "the picture follows the sound")).toBeTruthy();
});

it("never shows a delay below nothing, whatever the clocks' error", () => {
  show({ watching: [1] });
  act(() => {
    state.facts.value = { ...state.facts.value, pictureMs: -1.4 };
  });
  expect(button(/^Delay/).textContent).toBe("Delay0 ms");
});

describe("the tape", () => {
  const WHY = "Picture, sound and driving are recorded, without names.";

  function record(tape: Tape | null, options = {}): void {
    show({ watching: [1], ...options });
    act(() => {
      if (state.room.value) state.room.value = { ...state.room.value, tape };
    });
  }

  it("is not spoken of where nothing is recorded", () => {
    record(null);
    expect(queryByText(body, /recorded/i)).toBeNull();
  });

  it("tells everybody that they are recorded, and why", () => {
    record({ running: true, why: says(WHY) });
    expect(getByText(body, "Recorded")).toBeTruthy();
    expect(getByText(body, WHY)).toBeTruthy();
    expect(queryByText(body, "Keep the last two minutes")).toBeNull();
  });

  it("says why nothing is recorded", () => {
    record({ running: false, why: says("Nothing is recorded: the disk is full.") });
    expect(getByText(body, "Not recorded")).toBeTruthy();
    expect(getByText(body, "Nothing is recorded: the disk is full.")).toBeTruthy();
  });

  it("is kept by who drives", () => {
    record({ running: true, why: says(WHY) }, { watching: [], operator: 1 });
    getByText(body, "Keep the last two minutes").click();
    expect(actions.keepTape).toHaveBeenCalledOnce();
  });
});

it("shows a notice for a few seconds", () => {
  vi.useFakeTimers();
  act(() => {
    state.notice.value = { text: "There is no size 9x9." };
  });
  expect(getByText(body, "There is no size 9x9.")).toBeTruthy();
  act(() => {
    vi.advanceTimersByTime(7000);
  });
  expect(queryByText(body, "There is no size 9x9.")).toBeNull();
  vi.useRealTimers();
});

describe("speaking to the people beside the robot", () => {
  const VOICE: VoiceInfo = { speaker: null, muted: false, problem: null };

  function speakable(options: Parameters<typeof room>[0], more: Partial<VoiceInfo> = {}): void {
    vi.stubGlobal("isSecureContext", true);
    vi.stubGlobal("navigator", { ...navigator, mediaDevices: {} });
    show(options);
    act(() => {
      state.hello.value = hello({ viewer: 1, voice: { open_microphone: false } });
      state.room.value = { ...room(options), voice: { ...VOICE, ...more } };
    });
  }

  const speakButton = () => queryByRole(body, "button", { name: "Hold to speak" });

  afterEach(() => vi.unstubAllGlobals());

  it("is nothing where the robot has no speaker", () => {
    show({ operator: 1 });
    expect(speakButton()).toBeNull();
  });

  it("is for who drives, not for who watches", () => {
    speakable({ operator: 2, watching: [1] });
    expect(speakButton()).toBeNull();
    speakable({ operator: 1 });
    expect(speakButton()).toBeTruthy();
    expect(getByText(body, "Arrow keys or W A S D drive, T speaks, Space stops.")).toBeTruthy();
  });

  it("holds from the press to the release of a finger or Enter, never of Space", () => {
    speakable({ operator: 1 });
    pointer(button("Hold to speak"), "pointerdown", 7);
    expect(actions.speak).toHaveBeenLastCalledWith(fingerHolder(7));
    pointer(button("Hold to speak"), "pointerup", 7);
    expect(actions.hush).toHaveBeenLastCalledWith(fingerHolder(7));
    key(button("Hold to speak"), "keydown", "Enter");
    expect(actions.speak).toHaveBeenLastCalledWith("talk button");
    key(button("Hold to speak"), "keyup", "Enter");
    expect(actions.hush).toHaveBeenLastCalledWith("talk button");
    key(button("Hold to speak"), "keydown", "Space");
    expect(actions.speak).toHaveBeenCalledTimes(2);
  });

  it("says what becomes of the voice, how loud it is, and what is not heard meanwhile", () => {
    speakable({ operator: 1 });
    const HALF_DUPLEX = "While you speak, you do not hear the robot; the others do.";
    expect(getByText(body, HALF_DUPLEX)).toBeTruthy();
    act(() => {
      state.voice.value = { ...state.voice.value, isOn: true, level: 0.4 };
    });
    expect(getByText(body, `The microphone is on. ${HALF_DUPLEX}`)).toBeTruthy();
    act(() => {
      state.voice.value = { ...state.voice.value, isHeard: true };
    });
    expect(getByText(body, `You are heard. ${HALF_DUPLEX}`)).toBeTruthy();
    const meter = getByRole(body, "meter", { name: "Your voice" }) as HTMLMeterElement;
    expect(meter.getAttribute("value")).toBe("0.4");
    act(() => {
      state.voice.value = {
        ...state.voice.value,
        problem: "No microphone was found; plug one in.",
      };
    });
    expect(getByText(body, "No microphone was found; plug one in.")).toBeTruthy();
  });

  it("says nothing of the robot's sound where there is none", () => {
    speakable({ operator: 1 });
    act(() => {
      state.hello.value = hello({
        viewer: 1,
        has_microphone: false,
        voice: { open_microphone: false },
      });
      state.voice.value = { ...state.voice.value, isOn: true, isHeard: true };
    });
    expect(getByText(body, "You are heard.")).toBeTruthy();
  });

  it("says over plain HTTP what to do", () => {
    speakable({ operator: 1 });
    vi.stubGlobal("isSecureContext", false);
    act(() => {
      state.room.value = { ...room({ operator: 1 }), voice: VOICE };
      state.hello.value = hello({ viewer: 1, voice: { open_microphone: true } });
    });
    expect(getByText(body, /^A microphone needs HTTPS/)).toBeTruthy();
    expect(button("Hold to speak").disabled).toBe(true);
    expect(queryByRole(body, "switch", { name: "Keep open" })).toBeNull();
  });

  it("can be left open where the host allows it", () => {
    speakable({ operator: 1 });
    expect(queryByRole(body, "switch", { name: "Keep open" })).toBeNull();
    act(() => {
      state.hello.value = hello({ viewer: 1, voice: { open_microphone: true } });
    });
    act(() => getByRole(body, "switch", { name: "Keep open" }).click());
    expect(actions.keepSpeaking).toHaveBeenCalledExactlyOnceWith(true);
    act(() => {
      state.voice.value = { ...state.voice.value, isOn: true, isKept: true };
    });
    expect(button("Microphone open")).toBeTruthy();
  });

  it("tells everybody who is speaking, but not themselves", () => {
    speakable({ operator: 2, watching: [1] }, { speaker: 2 });
    expect(getByText(body, /^Bob is speaking to the people beside the robot/)).toBeTruthy();
    speakable({ operator: 1 }, { speaker: 1 });
    expect(queryByText(body, /is speaking to the people/)).toBeNull();
  });

  it("is the host's to end for everybody", () => {
    speakable({ operator: 2, watching: [1] });
    act(() => {
      state.hello.value = hello({ viewer: 1, is_host: true, voice: { open_microphone: false } });
    });
    open("Host");
    act(() => getByRole(body, "switch", { name: "Mute all voices" }).click());
    expect(actions.actAsHost).toHaveBeenCalledExactlyOnceWith({ type: "mute_voices", muted: true });
    act(() => {
      state.room.value = { ...room({ operator: 2 }), voice: { ...VOICE, muted: true } };
    });
    expect(getByText(body, "The host has muted all voices.")).toBeTruthy();
  });
});

describe("cameras beside the driving view", () => {
  const TWO = [
    { name: "Door", axes: [] },
    { name: "Above", axes: ["pan"] },
  ];
  const fine = { problem: null };

  function showTwo(more: { driving?: boolean; large?: number | null } = {}): void {
    show(more.driving ? { operator: 1 } : { watching: [1] }, ["pan", "arm"]);
    act(() => {
      state.hello.value = { ...(state.hello.value ?? hello()), cameras: TWO };
      state.room.value = { ...(state.room.value ?? room({})), cameras: [fine, fine] };
      state.served.value = served({ cameras: ["small", "small"] });
      state.large.value = more.large ?? null;
    });
  }

  it("are small, and a tap makes one large", () => {
    showTwo();
    button("Make Above large").click();
    expect(actions.enlarge).toHaveBeenCalledWith(1);
    expect(queryByRole(body, "button", { name: "Make Driving view large" })).toBeNull();
  });

  it("the driving view stays in sight beside a large one, and is called so", () => {
    showTwo({ driving: true, large: 0 });
    const views = body.querySelectorAll(".view");
    expect([...views].map((one) => one.querySelector("video") !== null)).toEqual([
      true,
      true,
      true,
    ]);
    expect(views[0]?.classList.contains("is-driving-view")).toBe(true);
    expect(body.querySelector(".views")?.classList.contains("is-watched")).toBe(true);
    expect(views[1]?.classList.contains("is-large")).toBe(true);
    button("Make Driving view large").click();
    expect(actions.enlarge).toHaveBeenCalledWith(null);
  });

  it("say why nothing is seen: the camera's own words, or the connection", () => {
    showTwo();
    act(() => {
      const failing = [{ problem: says("Door: The plug is out.") }, fine];
      state.room.value = { ...room({ watching: [1] }), cameras: failing };
      state.served.value = served({ cameras: ["small", null] });
    });
    expect(getByText(body, "Door: The plug is out.")).toBeTruthy();
    expect(getByText(body, "Your connection carries no more.")).toBeTruthy();
    expect(body.querySelectorAll(".view.is-old")).toHaveLength(2);
  });

  it("are greyed once they show nothing new", () => {
    showTwo();
    act(() => {
      state.staleCameras.value = new Set([1]);
    });
    const old = [...body.querySelectorAll(".view")].map((one) => one.classList.contains("is-old"));
    expect(old).toEqual([false, false, true]);
  });

  it("are gone with the picture, and while the host lets nobody see", () => {
    showTwo();
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
    });
    expect(body.querySelectorAll(".view")).toHaveLength(1);
  });

  it("can be left out, but for one that is large", () => {
    showTwo({ large: 1 });
    open("Settings");
    getByRole(body, "switch", { name: "Other cameras" }).click();
    expect(actions.setCameras).toHaveBeenCalledWith(false);
    act(() => {
      state.preferences.value = { ...state.preferences.value, cameras: false };
    });
    const hidden = [...body.querySelectorAll<HTMLElement>(".view")].map((one) => one.hidden);
    expect(hidden).toEqual([false, true, false]);
  });

  it("have the axes that turn them", () => {
    showTwo({ driving: true });
    expect(getByRole(body, "slider", { name: "pan of Above" })).toBeTruthy();
    expect(getByRole(body, "slider", { name: "arm" })).toBeTruthy();
  });

  it("are not offered where there are none", () => {
    show({ watching: [1] });
    open("Settings");
    expect(queryByRole(body, "switch", { name: "Other cameras" })).toBeNull();
  });
});

describe("a panel", () => {
  const close = () => button("Close the panel");

  it("gives the keyboard back to its tab when it is closed with a key", () => {
    for (const shut of [
      () => close().click(),
      () => close().dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true })),
    ]) {
      act(() => button("Settings").click());
      close().focus();
      act(() => void shut());
      expect(document.activeElement).toBe(button("Settings"));
    }
  });

  it("leaves the keyboard to driving when it is closed by a pointer", () => {
    act(() => button("Settings").click());
    act(() => {
      close().dispatchEvent(new MouseEvent("click", { detail: 1, bubbles: true }));
    });
    expect(document.activeElement).not.toBe(button("Settings"));
  });
});
