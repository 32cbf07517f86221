// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { describe, expect, it, vi } from "vitest";
import { fingerHolder } from "../drive/inputState";
import { UNHEARD_MS } from "../drive/keysDown";
import type { VoiceInfo } from "../messages";
import { hello, room } from "../testing/messages";
import { says } from "../words/said";
import {
  actions,
  body,
  button,
  drawsPage,
  key,
  open,
  pointer,
  show,
  state,
} from "./page.test.setup";

drawsPage();

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

  it("is not shown if the robot has no speaker", () => {
    show({ operator: 1 });
    expect(speakButton()).toBeNull();
  });

  it("is for the operator, not for observers", () => {
    speakable({ operator: 2, watching: [1] });
    expect(speakButton()).toBeNull();
    speakable({ operator: 1 });
    expect(speakButton()).toBeTruthy();
    expect(getByText(body, "Arrow keys or W A S D drive, T speaks, Space stops.")).toBeTruthy();
  });

  it("lasts from press to release of a finger or Enter, never of Space", () => {
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

  it("ends by itself if a keyup never comes, and does not start with Meta", () => {
    vi.useFakeTimers();
    speakable({ operator: 1 });
    const talk = button("Hold to speak");
    key(talk, "keydown", "Enter", { metaKey: true });
    expect(actions.speak).not.toHaveBeenCalled();
    key(talk, "keydown", "", { key: "Enter" });
    vi.advanceTimersByTime(UNHEARD_MS - 1);
    key(talk, "keydown", "", { key: "Enter", repeat: true });
    vi.advanceTimersByTime(UNHEARD_MS - 1);
    expect(actions.speak).toHaveBeenCalledOnce();
    expect(actions.hush).not.toHaveBeenCalled();
    vi.advanceTimersByTime(1);
    expect(actions.hush).toHaveBeenCalledExactlyOnceWith("talk button");
  });

  it("shows the voice's state and level, and that the robot is muted meanwhile", () => {
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
        problem: says("No microphone was found; plug one in."),
      };
    });
    expect(getByText(body, "No microphone was found; plug one in.")).toBeTruthy();
  });

  it("does not mention the robot's sound if it has none", () => {
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

  it("says what to do over plain HTTP", () => {
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

  it("can be kept open if the host allows it", () => {
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

  it("shows everybody else who is speaking", () => {
    speakable({ operator: 2, watching: [1] }, { speaker: 2 });
    expect(getByText(body, /^Bob is speaking to the people beside the robot/)).toBeTruthy();
    speakable({ operator: 1 }, { speaker: 1 });
    expect(queryByText(body, /is speaking to the people/)).toBeNull();
  });

  it("can be muted for everybody by the host", () => {
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
