import { expect, it } from "vitest";
import { pad, push } from "../testing/gamepads";
import { isPressed, loadLearnt } from "./learntParts";

const UP = { kind: "axis", at: 9, to: -1 } as const;

it("presses a button, or a hat in its direction alone", () => {
  const on = pad({ axes: Array.from({ length: 10 }, () => 0) });
  expect(isPressed(on, { kind: "button", at: 3, to: 1 })).toBe(false);
  push(on, 3);
  expect(isPressed(on, { kind: "button", at: 3, to: 1 })).toBe(true);
  for (const [value, isUp] of [
    [-1, true],
    [-5 / 7, false],
    [1, false],
    [9 / 7, false],
  ] as const) {
    on.axes[9] = value;
    expect(isPressed(on, UP)).toBe(isUp);
  }
  expect(isPressed(pad(), UP)).toBe(false);
});

it("is stored by gamepad, without what is not valid", () => {
  const good = { forward: UP, stop: { kind: "button", at: 3, to: 1 } };
  const bad = [null, 7, {}, { ...UP, kind: "wheel" }, { ...UP, at: -1 }, { ...UP, at: 0.5 }];
  const ends = [
    { ...UP, at: 64 },
    { ...UP, to: "1" },
    { ...UP, to: 9 },
  ];
  const all = Object.fromEntries([...bad, ...ends].map((part, i) => [`use${i}`, part]));
  expect(loadLearnt({ Stick: { ...good, ...all }, Broken: 5 })).toEqual({
    Stick: good,
    Broken: {},
  });
  expect(loadLearnt(null)).toEqual({});
  expect(loadLearnt("all")).toEqual({});
  const many = Object.fromEntries(Array.from({ length: 9 }, (_, i) => [`Pad ${i}`, good]));
  expect(Object.keys(loadLearnt(many))).toEqual(Object.keys(many).slice(1));
});
