import { beforeEach, expect, it } from "vitest";
import { Sequence } from "./sequence";

/** 20 ms of Opus: the packet's number is in its second byte. */
const block = (number: number, origin = 0) => ({
  rtp: (origin + number * 960) >>> 0,
  data: Uint8Array.from([31 << 3, number]),
});

let sequence: Sequence;
const numbers = (blocks: ReturnType<Sequence["add"]>) => blocks.map(({ data }) => data[1]);
const add = (nowMs: number, ...of: number[]) =>
  numbers(
    sequence.add(
      of.map((one) => block(one)),
      nowMs,
    ),
  );

beforeEach(() => {
  sequence = new Sequence();
});

it("passes on packets that arrive in order", () => {
  expect([add(0, 1), add(20, 2), add(40, 3)]).toEqual([[1], [2], [3]]);
});

it("drops duplicates and older packets", () => {
  add(0, 5);
  expect([add(1, 5), add(2, 4), add(3, 4, 5, 6)]).toEqual([[], [], [6]]);
});

it("fills a gap from a packet that repeats earlier ones", () => {
  add(0, 1);
  expect(add(40, 2, 3)).toEqual([2, 3]);
});

it("waits for an overtaken packet", () => {
  add(0, 1);
  expect([add(20, 3), add(25, 2)]).toEqual([[], [2, 3]]);
});

it("continues without a missing packet", () => {
  add(0, 1);
  add(20, 3);
  expect(sequence.nextDueMs).toBe(40);
  expect(numbers(sequence.due(39))).toEqual([]);
  expect(numbers(sequence.due(40))).toEqual([3]);
  expect(add(41, 2)).toEqual([]);
  expect(sequence.nextDueMs).toBeNull();
});

it("restarts for another sender", () => {
  add(0, 1);
  expect(numbers(sequence.add([block(2, 2 ** 31)], 20))).toEqual([2]);
  expect(numbers(sequence.add([block(3, 2 ** 31)], 40))).toEqual([3]);
});

it("continues across the wrap of RTP time", () => {
  const origin = 2 ** 32 - 960;
  sequence.add([block(0, origin)], 0);
  expect(numbers(sequence.add([block(1, origin)], 20))).toEqual([1]);
});

it("ignores anything but Opus", () => {
  add(0, 1);
  expect(sequence.add([{ rtp: 1920, data: new Uint8Array(0) }], 20)).toEqual([]);
});

it("passes on each packet once and in order, whatever the order of arrival", () => {
  let seed = 1;
  const random = () => {
    seed = (seed * 1_103_515_245 + 12_345) & 0x7fffffff;
    return seed / 0x7fffffff;
  };
  for (let round = 0; round < 200; round++) {
    const one = new Sequence();
    const passed: (number | undefined)[] = [];
    for (let step = 0; step < 100; step++) {
      const about = Math.max(1, step + Math.round((random() - 0.5) * 8));
      passed.push(...numbers(one.add([block(about)], step * 20 * random())));
    }
    const sorted = [...new Set(passed)].toSorted((a = 0, b = 0) => a - b);
    expect(passed).toEqual(sorted);
  }
});
