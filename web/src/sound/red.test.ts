import { expect, it } from "vitest";
import { splitRed } from "./red";

/** A packet by RFC 2198: earlier blocks, each with its age, then the newest. */
function red(earlier: [ticks: number, data: number[]][], newest: number[]): Uint8Array {
  const heads = earlier.flatMap(([ticks, { length }]) => [
    0x80 | 111,
    ticks >> 6,
    ((ticks & 0x3f) << 2) | (length >> 8),
    length & 0xff,
  ]);
  return Uint8Array.from([...heads, 111, ...earlier.flatMap(([, data]) => data), ...newest]);
}

const plain = (blocks: ReturnType<typeof splitRed>) =>
  blocks.map(({ rtp, data }) => [rtp, [...data]]);

it("returns repeated and new packets, oldest first", () => {
  const packet = red(
    [
      [1920, [1, 2]],
      [960, [3]],
    ],
    [4, 5],
  );
  expect(plain(splitRed(packet, 10_000))).toEqual([
    [8080, [1, 2]],
    [9040, [3]],
    [10_000, [4, 5]],
  ]);
});

it("reads ages and lengths beyond one byte, and times that wrap", () => {
  const long = Array.from({ length: 1023 }, (_, i) => i & 0xff);
  expect(plain(splitRed(red([[16_383, long]], [9]), 100))).toEqual([
    [2 ** 32 + 100 - 16_383, long],
    [100, [9]],
  ]);
});

it("returns a single packet without repetition", () => {
  expect(plain(splitRed(red([], [7]), 5))).toEqual([[5, [7]]]);
});

it("returns nothing for a truncated packet", () => {
  const packet = red([[960, [1, 2, 3]]], [4]);
  for (let length = 0; length < packet.length; length++) {
    expect(splitRed(packet.subarray(0, length), 0)).toEqual([]);
  }
});
