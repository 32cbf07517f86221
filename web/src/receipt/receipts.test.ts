import { expect, it } from "vitest";
import { SoundUnits } from "./receipts";

const units = (last_rtp: number, length = 4000) => ({ type: "units", last_rtp, length }) as const;

it("knows the last packet of each unit, before and after the one that was named", () => {
  const sound = new SoundUnits();
  sound.set(units(10_000));
  expect([10_000, 14_000, 18_000, 6000, 2000].map((rtp) => sound.isLast(rtp))).not.toContain(false);
  expect([9840, 10_160, 13_840].map((rtp) => sound.isLast(rtp))).not.toContain(true);
});

it("continues across the wrap at 2³²", () => {
  const sound = new SoundUnits();
  sound.set(units(2 ** 32 - 1000));
  expect(sound.isLast(3000)).toBe(true);
  expect(sound.isLast(2840)).toBe(false);
  expect(sound.isLast(2 ** 32 - 5000)).toBe(true);
});

it("returns earlier packets once the units are known", () => {
  const sound = new SoundUnits();
  expect(sound.isLast(3840)).toBe(false);
  expect(sound.isLast(4000)).toBe(false);
  expect(sound.set(units(8000))).toEqual([4000]);
  expect(sound.set(units(8000))).toEqual([]);
});

it("forgets the previous peer", () => {
  const sound = new SoundUnits();
  sound.isLast(4000);
  sound.set(units(4000));
  sound.isLast(8000);
  sound.reset();
  expect(sound.isLast(12_000)).toBe(false);
  expect(sound.set(units(400, 4000))).toEqual([]);
});
