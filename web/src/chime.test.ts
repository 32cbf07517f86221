import { expect, it, vi } from "vitest";
import { Chime } from "./chime";

/** As much of Web Audio as two notes need. */
function fakeContext() {
  const started: number[] = [];
  const peaks: number[] = [];
  const node = () => ({ connect: (to: unknown) => to });
  const context = {
    currentTime: 5,
    destination: {},
    resume: vi.fn(async () => {}),
    createOscillator: () => ({
      ...node(),
      frequency: { value: 0 },
      start: (atS: number) => started.push(atS),
      stop: () => {},
    }),
    createGain: () => ({
      ...node(),
      gain: {
        setValueAtTime: () => {},
        linearRampToValueAtTime: (value: number) => peaks.push(value),
      },
    }),
  };
  return { context: context as unknown as AudioContext, started, peaks };
}

it("plays two quiet notes, one after the other", () => {
  const { context, started, peaks } = fakeContext();
  new Chime(() => context).ring();
  expect(started).toHaveLength(2);
  expect(started[0]).toBe(5);
  expect(started[1]).toBeGreaterThan(5.1);
  expect(Math.max(...peaks)).toBeLessThanOrEqual(0.1);
});

it("tolerates being refused the device, as during a phone call", async () => {
  const { context } = fakeContext();
  const refused = new DOMException("", "InvalidStateError");
  vi.mocked(context.resume).mockRejectedValue(refused);
  new Chime(() => context).ring();
  await expect(context.resume()).rejects.toBe(refused);
});

it("is silent without Web Audio", () => {
  const chime = new Chime(() => {
    throw new TypeError("AudioContext is not a constructor");
  });
  expect(() => chime.ring()).not.toThrow();
});
