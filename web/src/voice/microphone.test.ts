// @vitest-environment dom
import { expect, it, vi } from "vitest";
import { hindrance, levelOf, Microphone } from "./microphone";

class Track extends EventTarget {
  stop = vi.fn();
}

function offer(getUserMedia: () => Promise<unknown>): void {
  vi.stubGlobal("isSecureContext", true);
  vi.stubGlobal("navigator", { mediaDevices: { getUserMedia } });
}

it("needs HTTPS, and says what to do", async () => {
  vi.stubGlobal("isSecureContext", false);
  expect(hindrance()).toMatch(/^A microphone needs HTTPS\. Open this page with https:/);
  await expect(Microphone.open(() => {})).rejects.toThrow("needs HTTPS");
});

it.each([
  ["NotAllowedError", "is not allowed here; allow it"],
  ["NotFoundError", "plug one in"],
  ["NotReadableError", "in use by another program"],
  ["OddError", "cannot be opened"],
])("%s is a sentence", async (name, sentence) => {
  offer(() => Promise.reject(new DOMException("x", name)));
  await expect(Microphone.open(() => {})).rejects.toThrow(sentence);
});

it("requests the browser's echo cancellation, and reports when the device is gone", async () => {
  const track = new Track();
  const getUserMedia = vi.fn(async () => ({ getAudioTracks: () => [track] }));
  offer(getUserMedia);
  const gone = vi.fn();
  const microphone = await Microphone.open(gone);
  expect(getUserMedia).toHaveBeenCalledWith({
    audio: expect.objectContaining({ echoCancellation: true, channelCount: 1 }),
  });
  expect(microphone.level).toBe(0);
  track.dispatchEvent(new Event("ended"));
  expect(gone).toHaveBeenCalledExactlyOnceWith("The microphone has gone; plug it in again.");
  microphone.close();
  expect(track.stop).toHaveBeenCalled();
});

it("rejects a stream without a track", async () => {
  offer(async () => ({ getAudioTracks: () => [] }));
  await expect(Microphone.open(() => {})).rejects.toThrow("No microphone was found");
});

it("shows the level linear in dB", () => {
  const level = (amplitude: number) => levelOf(new Float32Array(100).fill(amplitude));
  expect(level(0)).toBe(0);
  expect(level(1)).toBeCloseTo(1);
  expect(level(0.1)).toBeCloseTo(2 / 3);
  expect(level(0.0001)).toBe(0);
});
