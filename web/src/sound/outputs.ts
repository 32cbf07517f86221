/** The devices on which the sound can play, as far as the browser tells. */

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

/** Whether it asks the user itself (Audio Output Devices API, `selectAudioOutput`). */
export function asksForOutput(scope: typeof globalThis = globalThis): boolean {
  return typeof devicesOf(scope)?.selectAudioOutput === "function";
}

/** Only over HTTPS are there any. */
export function devicesOf(scope: typeof globalThis = globalThis): Devices | null {
  return (scope.navigator?.mediaDevices as Devices | undefined) ?? null;
}

/** Those that have a name. Browsers name them once the page may use the microphone, or was told. */
export async function listOutputs(devices: Devices): Promise<Output[]> {
  const all = await devices.enumerateDevices();
  return all
    .filter(
      ({ kind, deviceId, label }) => kind === "audiooutput" && deviceId !== "" && label !== "",
    )
    .filter(({ deviceId }) => deviceId !== "default" && deviceId !== "communications")
    .map(({ deviceId, label }) => ({ id: deviceId, name: label }));
}

/** What the user chooses in the browser's own dialog; null if that was dismissed. */
export async function askForOutput(devices: Devices): Promise<Output | null> {
  try {
    const chosen = await devices.selectAudioOutput?.();
    return chosen ? { id: chosen.deviceId, name: chosen.label } : null;
  } catch {
    return null;
  }
}

/** Calls `gone` when the device with this id is unplugged; returns a function that ends it. */
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
