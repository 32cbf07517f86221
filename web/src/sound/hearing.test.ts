import { beforeEach, expect, it, vi } from "vitest";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { eventually } from "../testing/eventually";
import { createHearing, type HearingActions } from "./hearing";

const HEADPHONES = { id: "h", name: "Headphones" };

let state: State;
let sound: {
  volume: number;
  isMuted: boolean;
  setOutput: ReturnType<typeof vi.fn<(id: string) => Promise<boolean>>>;
};
let start: ReturnType<typeof vi.fn<() => void>>;
let say: ReturnType<typeof vi.fn<(text: string) => void>>;
let hearing: HearingActions;
let devices: EventTarget & { enumerateDevices: () => Promise<object[]> };

function open(kept = {}): void {
  state = createState({ ...loadPreferences(null), ...kept });
  hearing = createHearing({
    state,
    sound,
    prefer: (change) => {
      state.preferences.value = { ...state.preferences.peek(), ...change };
    },
    start,
    say,
  });
}

beforeEach(() => {
  sound = { volume: 1, isMuted: false, setOutput: vi.fn(async () => true) };
  start = vi.fn(() => {
    state.isSoundOn.value = true;
  });
  say = vi.fn();
  devices = Object.assign(new EventTarget(), { enumerateDevices: async () => [] as object[] });
  vi.stubGlobal("navigator", { mediaDevices: devices });
  open();
});

it("starts with the stored volume", () => {
  open({ volume: 0.3, muted: true });
  expect([sound.volume, sound.isMuted]).toEqual([0.3, true]);
});

it("stores the volume, and a change of it unmutes", () => {
  hearing.setMuted(true);
  hearing.setVolume(0.4);
  expect(sound).toMatchObject({ volume: 0.4, isMuted: false });
  expect(state.preferences.value).toMatchObject({ volume: 0.4, muted: false });
  hearing.setVolume(7);
  expect(sound.volume).toBe(1);
});

it("mutes and unmutes by the same key, even before Start", () => {
  hearing.toggleMute();
  expect(start).toHaveBeenCalledOnce();
  expect(sound.isMuted).toBe(false);
  hearing.toggleMute();
  expect([sound.isMuted, state.preferences.value.muted]).toEqual([true, true]);
  hearing.toggleMute();
  expect(sound.isMuted).toBe(false);
  expect(start).toHaveBeenCalledOnce();
});

it("plays on the chosen device until that is unplugged, and says so", async () => {
  hearing.setOutput(HEADPHONES);
  await eventually(() => expect(sound.setOutput).toHaveBeenCalledWith("h"));
  expect(state.output.value).toBe(HEADPHONES);
  await Promise.resolve();
  devices.dispatchEvent(new Event("devicechange"));
  await eventually(() => expect(sound.setOutput).toHaveBeenLastCalledWith(""));
  expect(state.output.value).toBeNull();
  expect(say).toHaveBeenCalledExactlyOnceWith(expect.stringContaining("Headphones"));
});

it("says if a device does not exist", async () => {
  sound.setOutput.mockResolvedValueOnce(false);
  hearing.setOutput(HEADPHONES);
  await eventually(() => expect(say).toHaveBeenCalledOnce());
  expect(state.output.value).toBeNull();
});

it("says nothing about a device that is no longer chosen", async () => {
  hearing.setOutput(HEADPHONES);
  await Promise.resolve();
  hearing.setOutput(null);
  await Promise.resolve();
  devices.dispatchEvent(new Event("devicechange"));
  await new Promise((done) => setTimeout(done));
  expect(say).not.toHaveBeenCalled();
});
