import { expect, it } from "vitest";
import { newRequest } from "./aboard";
import { aboard, room } from "./testing/messages";

const before = { ...room({ operator: 1 }), aboard: aboard({ asked: "left", asks: 3 }) };

it("is new when its number is another", () => {
  const again = { ...before, aboard: aboard({ asked: "left", asks: 4 }) };
  expect(newRequest(before, again)).toBe("left");
  const other = { ...before, aboard: aboard({ asked: "wait", asks: 5 }) };
  expect(newRequest(before, other)).toBe("wait");
});

it("is old while its number stays, whatever else changes", () => {
  const later = { ...before, aboard: aboard({ mode: "hand", asked: "left", asks: 3 }) };
  expect(newRequest(before, later)).toBeNull();
});

it("is not new to a page that has just connected, or with nobody aboard", () => {
  expect(newRequest(null, before)).toBeNull();
  expect(newRequest(room({}), before)).toBeNull();
  expect(newRequest(before, room({}))).toBeNull();
});

it("is none when a robot restarts its count", () => {
  expect(newRequest(before, { ...before, aboard: aboard() })).toBeNull();
});
