import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { type ScanItem, Scanner } from "./scanner";

let dwellMs: number | null;
let isPlanar: boolean;
let offered: (ScanItem | null)[];
const choose = vi.fn();
let scanner: Scanner;

beforeEach(() => {
  vi.useFakeTimers();
  choose.mockClear();
  dwellMs = 1000;
  isPlanar = false;
  offered = [];
  scanner = new Scanner({
    dwellMs: () => dwellMs,
    movesSideways: () => isPlanar,
    offer: (item) => offered.push(item),
    choose,
  });
});

afterEach(() => {
  scanner.end();
});

it("cycles through the items, Stop among them", () => {
  scanner.begin(false);
  vi.advanceTimersByTime(5000);
  expect(offered).toEqual(["forward", "left", "right", "back", "stop", "forward"]);
});

it("offers to move sideways too, if the robot can", () => {
  isPlanar = true;
  scanner.begin(false);
  vi.advanceTimersByTime(7000);
  expect(offered).toEqual([
    "forward",
    "left",
    "right",
    "lateral_left",
    "lateral_right",
    "back",
    "stop",
    "forward",
  ]);
});

it("chooses the offered item, and offers it again for as long", () => {
  scanner.begin(false);
  vi.advanceTimersByTime(1900);
  scanner.select();
  expect(choose).toHaveBeenCalledExactlyOnceWith("left");
  vi.advanceTimersByTime(900);
  scanner.select();
  expect(choose).toHaveBeenLastCalledWith("left");
  vi.advanceTimersByTime(1000);
  expect(offered.at(-1)).toBe("right");
});

it("waits for the second switch if there are two", () => {
  dwellMs = null;
  scanner.begin(false);
  vi.advanceTimersByTime(60_000);
  expect(offered).toEqual(["forward"]);
  scanner.next();
  scanner.select();
  expect(choose).toHaveBeenCalledExactlyOnceWith("left");
});

it("offers only the release while a stop is in force", () => {
  scanner.begin(true);
  vi.advanceTimersByTime(2500);
  expect(new Set(offered)).toEqual(new Set(["release"]));
  scanner.select();
  expect(choose).toHaveBeenCalledExactlyOnceWith("release");
});

it("offers and chooses nothing before its start and after its end", () => {
  scanner.select();
  scanner.next();
  scanner.begin(false);
  scanner.end();
  scanner.select();
  scanner.next();
  vi.advanceTimersByTime(10_000);
  expect(offered).toEqual(["forward", null]);
  expect(choose).not.toHaveBeenCalled();
});
