import { beforeEach, expect, it } from "vitest";
import { enough, inQuality, RenditionChoice } from "./rendition";

let choice: RenditionChoice;
let nowMs: number;

beforeEach(() => {
  choice = new RenditionChoice();
  nowMs = 0;
});

/** Measures once a second; returns after how many seconds the choice changed, null if never. */
function after(seconds: number, arriving: { delayMs?: number | null; frozenMs?: number } = {}) {
  const before = choice.isSmall;
  for (let i = 1; i <= seconds; i++) {
    nowMs += 1000;
    choice.add({ delayMs: 40, frozenMs: 0, ...arriving }, nowMs);
    if (choice.isSmall !== before) return i;
  }
  return null;
}

it("orders the publishers by the rate in their names", () => {
  const [best, small] = ["robot 640x480 at 1000 kbit/s", "robot 320x240 at 150 kbit/s"];
  expect(inQuality([small, best])).toEqual([best, small]);
  expect(inQuality([best, small])).toEqual([best, small]);
  expect(inQuality(["robot b", "robot a", best])).toEqual([best, "robot a", "robot b"]);
});

it.each([
  ["1280x720", 0],
  ["960x540", 0],
  ["640x360", 0],
  ["320x180", 1],
  ["160x90", 1],
])("who asks for %s gets the smallest picture that need not be enlarged", (size, i) => {
  const publishers = ["robot 960x540 at 1000 kbit/s", "robot 320x180 at 120 kbit/s"];
  expect(enough(publishers, size)).toBe(publishers[i]);
  expect(enough([], size)).toBeUndefined();
});

it("gives the best of publishers whose names tell no size", () => {
  expect(enough(["robot a", "robot b"], "320x180")).toBe("robot a");
});

it("chooses the better picture if the link carries it", () => {
  expect(after(600)).toBeNull();
  expect(choice.isSmall).toBe(false);
});

it("chooses the smaller one if pictures queue, whatever the clocks' offset", () => {
  after(10, { delayMs: -5000 });
  expect(after(10, { delayMs: -4700 })).toBe(2);
});

it("chooses the smaller one if pictures freeze, even without known ages", () => {
  after(10, { delayMs: null });
  expect(after(10, { delayMs: null, frozenMs: 300 })).toBe(2);
});

it("ignores a single bad second", () => {
  after(5);
  for (let i = 0; i < 10; i++) {
    expect(after(1, { frozenMs: 900 })).toBeNull();
    expect(after(1)).toBeNull();
  }
});

it("retries the better one after ever longer calm, and takes two seconds to reject it", () => {
  after(5);
  const calm = [1, 2, 3].map(() => {
    const badS = after(600, { frozenMs: 500 });
    expect(badS).toBeGreaterThanOrEqual(2);
    return after(600);
  });
  expect(calm[0]).toBeGreaterThanOrEqual(10);
  expect(calm[1]).toBeGreaterThan(calm[0] ?? 0);
  expect(calm[2]).toBeGreaterThan(calm[1] ?? 0);
});

it("trusts the better one again after it has lasted", () => {
  const again = () => {
    after(600, { frozenMs: 500 });
    return after(600);
  };
  again();
  const second = again();
  after(60);
  expect(again()).toBeLessThan(second ?? 0);
});

it("forgets the previous room's delay", () => {
  after(10, { delayMs: 0 });
  choice.forget();
  expect(after(60, { delayMs: 5000 })).toBeNull();
});
