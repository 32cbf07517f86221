/** The devices on which the sound can play, as far as the browser reports them. */

export interface Output {
  id: string;
  name: string;
}

type Devices = Pick<MediaDevices, "enumerateDevices" | "addEventListener"> & {
  selectAudioOutput?: () => Promise<MediaDeviceInfo>;
};

/** Whether this browser lets a page choose the device. */
export function choosesOutputs(scope: typeof globalThis = globalThis): boolean {
  const media = scope.HTMLMediaElement?.prototype ?? {};
  return "setSinkId" in media && devicesOf(scope) !== null;
}

/** Whether the browser asks the user (Audio Output Devices API, `selectAudioOutput`). */
export function asksForOutput(scope: typeof globalThis = globalThis): boolean {
  return typeof devicesOf(scope)?.selectAudioOutput === "function";
}

/** The browser's media devices; null without HTTPS. */
export function devicesOf(scope: typeof globalThis = globalThis): Devices | null {
  return (scope.navigator?.mediaDevices as Devices | undefined) ?? null;
}

/** Lists the outputs that the page may name: with microphone permission, or once chosen. */
export async function listOutputs(devices: Devices): Promise<Output[]> {
  const all = await devices.enumerateDevices();
  return all
    .filter(
      ({ kind, deviceId, label }) => kind === "audiooutput" && deviceId !== "" && label !== "",
    )
    .filter(({ deviceId }) => deviceId !== "default" && deviceId !== "communications")
    .map(({ deviceId, label }) => ({ id: deviceId, name: label }));
}

/** The user's choice in the browser's own dialog; null if that was dismissed. */
export async function askForOutput(devices: Devices): Promise<Output | null> {
  try {
    const chosen = await devices.selectAudioOutput?.();
    return chosen ? { id: chosen.deviceId, name: chosen.label } : null;
  } catch {
    return null;
  }
}

/** Calls `gone` when the device with this id is unplugged; returns what stops watching. */
export function watchOutput(devices: Devices, id: string, gone: () => void): () => void {
  const watching = new AbortController();
  const look = async () => {
    const all = await devices.enumerateDevices();
    const isThere = all.some((one) => one.kind === "audiooutput" && one.deviceId === id);
    if (!isThere && !watching.signal.aborted) gone();
  };
  devices.addEventListener("devicechange", () => void look(), { signal: watching.signal });
  return () => watching.abort();
}
