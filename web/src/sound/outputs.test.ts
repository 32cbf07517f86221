import { expect, it, vi } from "vitest";
import { eventually } from "../testing/eventually";
import { askForOutput, asksForOutput, choosesOutputs, listOutputs, watchOutput } from "./outputs";

interface Device {
  kind: string;
  deviceId: string;
  label: string;
}

const HEADPHONES = { kind: "audiooutput", deviceId: "h", label: "Headphones" };

class FakeDevices extends EventTarget {
  all: Device[] = [
    { kind: "audiooutput", deviceId: "default", label: "Default" },
    { kind: "audiooutput", deviceId: "communications", label: "Communications" },
    HEADPHONES,
    { kind: "audiooutput", deviceId: "x", label: "" },
    { kind: "audioinput", deviceId: "m", label: "Microphone" },
  ];
  selectAudioOutput = vi.fn(async () => HEADPHONES);
  enumerateDevices = async () => this.all;
}

const asDevices = (devices: FakeDevices) => devices as unknown as MediaDevices;
const scope = (of: object) => of as unknown as typeof globalThis;

it("lists the outputs that have a name, but not their aliases", async () => {
  expect(await listOutputs(asDevices(new FakeDevices()))).toEqual([
    { id: "h", name: "Headphones" },
  ]);
});

it("returns the user's choice in the browser's dialog, or null if dismissed", async () => {
  const devices = new FakeDevices();
  expect(await askForOutput(asDevices(devices))).toEqual({ id: "h", name: "Headphones" });
  devices.selectAudioOutput.mockRejectedValueOnce(new DOMException("no", "NotAllowedError"));
  expect(await askForOutput(asDevices(devices))).toBeNull();
});

it("notices only that the chosen one is unplugged", async () => {
  const devices = new FakeDevices();
  const gone = vi.fn();
  watchOutput(asDevices(devices), "h", gone);
  devices.all = devices.all.filter((one) => one.deviceId !== "m");
  devices.dispatchEvent(new Event("devicechange"));
  await Promise.resolve();
  expect(gone).not.toHaveBeenCalled();
  devices.all = [];
  devices.dispatchEvent(new Event("devicechange"));
  await eventually(() => expect(gone).toHaveBeenCalledOnce());
});

it("stops watching once another is chosen", async () => {
  const devices = new FakeDevices();
  const gone = vi.fn();
  watchOutput(asDevices(devices), "h", gone)();
  devices.all = [];
  devices.dispatchEvent(new Event("devicechange"));
  await Promise.resolve();
  await Promise.resolve();
  expect(gone).not.toHaveBeenCalled();
});

it("knows what the browser can", () => {
  const media = { HTMLMediaElement: { prototype: { setSinkId: 1 } } };
  const mediaDevices = new FakeDevices();
  expect(choosesOutputs(scope({ ...media, navigator: { mediaDevices } }))).toBe(true);
  expect(choosesOutputs(scope({ ...media, navigator: {} }))).toBe(false);
  expect(choosesOutputs(scope({ navigator: { mediaDevices } }))).toBe(false);
  expect(asksForOutput(scope({ navigator: { mediaDevices } }))).toBe(true);
  expect(asksForOutput(scope({ navigator: { mediaDevices: {} } }))).toBe(false);
});
