import { describe, expect, it } from "vitest";
import { type FakePad, pad, push } from "../testing/gamepads";
import type { Learnt } from "./learntParts";
import { layoutOf, type PadSettings, readPad } from "./padReading";

const SETTINGS: PadSettings = {
  turn: "left",
  planarTurn: "right",
  triggers: true,
  deadZone: 0.2,
  curve: 1,
  rests: {},
  learnt: {},
};

/** The reading of a pad after this was done on it. */
function said(
  doing: (on: FakePad) => void,
  more: Partial<FakePad> = {},
  settings = {},
  movesSideways = false,
) {
  const on = pad(more);
  doing(on);
  return readPad(on, { ...SETTINGS, ...settings }, movesSideways);
}

it("asks for nothing while untouched", () => {
  expect(said(() => {})).toEqual({
    motion: { linear: 0, angular: 0 },
    directions: new Set(),
    stop: false,
    speed: false,
    start: false,
    controls: new Set(),
    held: [],
    axes: [
      { at: 0, value: 0, rest: 0 },
      { at: 1, value: 0, rest: 0 },
    ],
  });
});

describe("the sticks", () => {
  it.each([
    ["ahead", [0, -0.6, 0, 0], { linear: 0.5, angular: 0 }],
    ["back", [0, 1, 0, 0], { linear: -1, angular: 0 }],
    ["left", [-1, 0, 0, 0], { linear: 0, angular: 1 }],
    ["right", [0.6, 0, 0, 0], { linear: 0, angular: -0.5 }],
    ["nothing in the dead zone", [0.1, -0.1, 0, 0], { linear: 0, angular: 0 }],
    ["nothing of the right one", [0, 0, 1, 1], { linear: 0, angular: 0 }],
  ])("ask for %s", (_, axes, motion) => {
    const reading = said(() => {}, { axes });
    expect(reading.motion.linear).toBeCloseTo(motion.linear, 10);
    expect(reading.motion.angular).toBeCloseTo(motion.angular, 10);
    expect(reading.held.length === 0).toBe(motion.linear === 0 && motion.angular === 0);
  });

  it("turn by the right one if the user wants that", () => {
    const { motion } = said(() => {}, { axes: [1, -0.6, -1, 1] }, { turn: "right" });
    expect(motion.linear).toBeCloseTo(0.5, 10);
    expect(motion.angular).toBe(1);
  });
});

describe("a robot that moves sideways", () => {
  const read = (axes: number[], settings = {}, mapping: GamepadMappingType = "standard") =>
    said(() => {}, { axes, mapping }, settings, true);

  it.each([
    ["ahead", [0, -1, 0, 0], { linear: 1, angular: 0, lateral: 0 }],
    ["to the left", [-1, 0, 0, 0], { linear: 0, angular: 0, lateral: 1 }],
    ["to the right", [0.6, 0, 0, 0], { linear: 0, angular: 0, lateral: -0.5 }],
    ["round to the left", [0, 0, -1, 0], { linear: 0, angular: 1, lateral: 0 }],
    ["in no direction by the right one's other axis", [0, 0, 0, 1], { linear: 0, angular: 0 }],
  ])("is moved %s by the left stick, and turned by the right one", (_, axes, motion) => {
    const { motion: is, held } = read(axes);
    for (const [name, value] of Object.entries(motion))
      expect(is[name as keyof typeof motion]).toBeCloseTo(value, 10);
    expect(held.length === 0).toBe(Object.values(motion).every((one) => one === 0));
  });

  it.each([
    ["a square", 1],
    ["a circle", Math.SQRT1_2],
  ])("goes at full speed on a diagonal, no faster, if the stick's travel is %s", (_, way) => {
    const { linear, lateral = 0 } = read([way, -way, 0, 0]).motion;
    expect(Math.hypot(linear, lateral)).toBeCloseTo(1, 2);
  });

  it("turns by the left stick and moves sideways by the right one, if the user wants that", () => {
    const { motion, axes, held } = read([-1, 0, 1, 0], { planarTurn: "left" });
    expect(motion).toEqual({ linear: 0, angular: 1, lateral: -1 });
    expect(axes.map(({ at }) => at).sort()).toEqual([0, 1, 2]);
    expect(held.map(({ at }) => at)).toEqual([0, 2]);
  });

  it("moves sideways by LB and RB in the chosen way, which another robot does not", () => {
    const both = (on: FakePad) => [4, 5].forEach((at) => void push(on, at));
    const directions = new Set(["lateral_left", "lateral_right"]);
    expect(said(both, {}, {}, true).directions).toEqual(directions);
    expect(said(both).directions).toEqual(new Set());
  });

  it("is driven like any other by a pad of an unknown layout", () => {
    expect(read([-1, 0, -1, 0], {}, "").motion).toEqual({ linear: 0, angular: 1 });
  });
});

describe("the triggers", () => {
  it("drive ahead and back", () => {
    expect(said((on) => push(on, 7, 0.6)).motion.linear).toBeCloseTo(0.5, 10);
    expect(said((on) => push(on, 6)).motion.linear).toBe(-1);
  });

  it("add to the stick, within the limits", () => {
    const reading = said((on) => push(on, 7), { axes: [0, -1, 0, 0] });
    expect(reading.motion.linear).toBe(1);
  });

  it("are not neutral when they cancel each other", () => {
    const reading = said((on) => {
      on.buttons[6] = { pressed: false, touched: true, value: 0.8 };
      on.buttons[7] = { pressed: false, touched: true, value: 0.8 };
    });
    expect(reading.motion.linear).toBe(0);
    expect(reading.held).toEqual([
      { kind: "button", at: 6 },
      { kind: "button", at: 7 },
    ]);
  });

  it("do nothing if the user wants that", () => {
    expect(said((on) => push(on, 7), {}, { triggers: false }).motion.linear).toBe(0);
  });
});

it.each([
  [12, "forward"],
  [13, "back"],
  [14, "left"],
  [15, "right"],
])("button %d of the cross is %s", (at, direction) => {
  expect(said((on) => push(on, at)).directions).toEqual(new Set([direction]));
});

it.each([
  [0, "speed"],
  [1, "stop"],
  [9, "start"],
] as const)("button %d is %s, and keeps the pad from being neutral", (at, name) => {
  const reading = said((on) => push(on, at));
  expect([reading[name], reading.held]).toEqual([true, [{ kind: "button", at }]]);
});

it("uses only the first stick, Stop and speed of an unknown layout", () => {
  const all = (on: FakePad) => {
    for (let at = 0; at < 17; at++) push(on, at);
  };
  const reading = said(all, { mapping: "", axes: [0, -1, 1, 1] }, { turn: "right" });
  expect(reading).toMatchObject({
    motion: { linear: 1, angular: 0 },
    directions: new Set(),
    stop: true,
    speed: true,
    start: false,
  });
});

it("reads a pad with fewer axes and buttons", () => {
  const reading = said(() => {}, { axes: [], buttons: [] }, { turn: "right" });
  expect(reading).toMatchObject({ motion: { linear: 0, angular: 0 }, held: [] });
});

/** Real pads, as the browser reports them while untouched. */
const UNTOUCHED: [string, Partial<FakePad>, on?: number[]][] = [
  [
    "a throttle whose mode switch is button 24 of 34",
    { axes: [0.004, 0.004, 1, 0, 0, 0.01, 0] },
    [24],
  ],
  [
    "a throttle with eight switches that stay on",
    { axes: [0.02, 0, -1, 1, -0.53] },
    [14, 16, 21, 22, 23, 26, 28, 31],
  ],
  ["a pad whose triggers are axes that rest at -1", { axes: [0, 0, -1, 0, 0, -1, 0, 0] }],
  [
    "a pad whose cross is an axis that rests at 3.29",
    { axes: [0.00392, 0.00392, 0, 0, 0, 0, 0, 0, 0, 3.28571] },
  ],
  ["a stick that trembles by 0.05", { axes: [0.05, -0.05, 0.05, -0.05] }],
  [
    "a standard pad whose trigger rests at 0.13, which counts as pressed",
    { mapping: "standard" },
    [7],
  ],
  ["a standard pad with a paddle that is stuck", { mapping: "standard" }, [17]],
];

it.each(UNTOUCHED)("counts %s as untouched", (_, more, on = []) => {
  const many = pad().buttons.concat(pad().buttons);
  const push = (to: FakePad) => {
    for (const at of on)
      to.buttons[at] = { pressed: true, touched: true, value: at === 7 ? 0.13 : 1 };
  };
  const reading = said(push, { mapping: "", buttons: many, ...more });
  expect([reading.held, reading.motion]).toEqual([[], { linear: 0, angular: 0 }]);
});

it.each([
  [
    "a lever as its second axis that stays where it is",
    [0, -0.6, 0],
    [],
    [{ kind: "axis", at: 1 }],
  ],
  [
    "pedals that rest at an end",
    [-1, -1, 0],
    [],
    [
      { kind: "axis", at: 0 },
      { kind: "axis", at: 1 },
    ],
  ],
  [
    "a wheel whose pedals rest at 1, one as its second axis",
    [0, 1, 1, 0, 0, 1],
    [],
    [{ kind: "axis", at: 1 }],
  ],
  ["a lever beside a stick that is hardly moved", [0.004, -0.6], [], [{ kind: "axis", at: 1 }]],
  [
    "a stick that is aside by both of its axes together",
    [0.16, 0.16],
    [],
    [
      { kind: "axis", at: 0 },
      { kind: "axis", at: 1 },
    ],
  ],
  ["a switch in the place of Stop", [0, 0], [1, 5], [{ kind: "button", at: 1 }]],
])("names what holds of %s", (_, axes, on, held) => {
  const reading = said((to) => on.forEach((at) => void push(to, at)), { mapping: "", axes });
  expect(reading.held).toEqual(held);
});

describe("an axis with a stored rest", () => {
  const ahead = (rest: number, value: number) =>
    -said(
      () => {},
      { mapping: "", axes: [0, value] },
      { deadZone: 0.1, rests: { Xbox: [0, rest, 0] } },
    ).motion.linear;

  it.each([
    ["stands there", -1, -1, 0],
    ["reaches to the other end", -1, 1, 1],
    ["counts from there, as far as the end is", -0.5, -0.95, -0.889],
    ["counts so on the longer side, too", -0.5, 0.55, 0.667],
    ["trembles by a short way to an end without being magnified", 0.95, 1, 0],
    ["goes beyond its ends no further", 1, 3.29, 0],
    ["is let go where it says no number", -1, Number.NaN, 0],
  ])("%s", (_, rest, value, is) => {
    expect(ahead(rest, value)).toBeCloseTo(is, 3);
  });

  it("ignores another pad's rest", () => {
    const rests = { Other: [0, -1, 0] };
    expect(said(() => {}, { axes: [0, -1] }, { rests }).motion.linear).toBe(1);
  });
});

it.each([
  ["standard", 17, "standard"],
  ["standard", 8, "unknown"],
  ["", 34, "unknown"],
  ["", 1, "bare"],
] as const)("a pad of mapping %j with %d buttons is %s", (mapping, count, layout) => {
  expect(layoutOf({ mapping, buttons: pad().buttons.concat(pad().buttons).slice(0, count) })).toBe(
    layout,
  );
});

describe("what was taught", () => {
  const teach = (parts: Learnt) => ({ learnt: { Xbox: parts } });
  const axis = (at: number, to: number) => ({ kind: "axis", at, to }) as const;
  const button = (at: number) => ({ kind: "button", at, to: 1 }) as const;

  it("drives by a throttle and a rudder among many axes, which others' do not", () => {
    const parts = { ...teach({ ahead: axis(5, 1), turn: axis(6, -1) }) };
    const settings = { ...parts, rests: { Xbox: [0, 0, 0, 0, 0, -1, 0] } };
    const axes = [1, -1, 0, 0, 0, 0.5, -0.6];
    const reading = said(() => {}, { axes, mapping: "" }, settings);
    expect(reading.motion.linear).toBeCloseTo((0.75 - 0.2) / 0.8, 10);
    expect(reading.motion.angular).toBeCloseTo(0.5, 10);
    expect(reading.held.map(({ at }) => at)).toEqual([5, 6]);
    expect(reading.axes.map(({ at, rest }) => [at, rest])).toEqual([
      [5, -1],
      [6, 0],
    ]);
    const other = said(() => {}, { axes, mapping: "", id: "Other" }, settings);
    expect(other.motion).toMatchObject({ linear: expect.closeTo(0.7, 1) });
    expect(said(() => {}, { axes: [], mapping: "" }, parts).motion).toEqual({
      linear: 0,
      angular: 0,
    });
  });

  it("moves a robot sideways that can, by a pad of any layout", () => {
    const settings = teach({ sideways: axis(3, -1) });
    for (const mapping of ["", "standard"] as const) {
      const more = { axes: [0, 0, 0, -1], mapping };
      expect(said(() => {}, more, settings, true).motion).toEqual({
        linear: 0,
        angular: 0,
        lateral: 1,
      });
      expect(said(() => {}, more, settings).motion).toEqual({ linear: 0, angular: 0 });
    }
  });

  it("is a hat's direction, and it is held as long as the hat is", () => {
    const settings = teach({ forward: axis(9, -1) });
    const axes = (hat: number) => [...Array.from({ length: 9 }, () => 0), hat];
    const pushed = said(() => {}, { axes: axes(-1), mapping: "" }, settings);
    expect(pushed.directions).toEqual(new Set(["forward"]));
    expect(pushed.held).toEqual([{ kind: "axis", at: 9 }]);
    const rests = said(() => {}, { axes: axes(9 / 7), mapping: "" }, settings);
    expect([rests.directions.size, rests.held.length]).toEqual([0, 0]);
  });

  it("takes a button from what it did before, and must be let go of like it", () => {
    const settings = teach({ speed: button(7), "control horn": button(1), stop: button(16) });
    const reading = said(
      (on) => [0, 1, 7].forEach((at) => void push(on, at)),
      { mapping: "" },
      settings,
    );
    expect(reading).toMatchObject({ stop: false, speed: true, motion: { linear: 0 } });
    expect(reading.held.map(({ at }) => at)).toEqual([0, 1, 7]);
    expect(said((on) => push(on, 16), {}, settings).stop).toBe(true);
    expect(said((on) => push(on, 7), {}, settings).motion.linear).toBe(0);
  });

  it("leaves the usual button for Stop in force", () => {
    expect(said((on) => push(on, 1), {}, teach({ stop: button(3) })).stop).toBe(true);
  });
});

describe("the robot's controls", () => {
  const controls = [
    { name: "horn", pad_button: "X" },
    { name: "lamp", pad_button: "" },
  ];
  const read = (at: number, mapping: GamepadMappingType, learnt: Learnt = {}) => {
    const on = pad({ mapping });
    push(on, at);
    return readPad(on, { ...SETTINGS, learnt: { Xbox: learnt } }, false, controls).controls;
  };

  it("are pressed by the host's buttons on a standard gamepad, and by what was taught on any", () => {
    expect(read(2, "standard")).toEqual(new Set(["horn"]));
    expect(read(2, "")).toEqual(new Set());
    const learnt = { "control lamp": { kind: "button", at: 2, to: 1 } } as const;
    expect(read(2, "standard", learnt)).toEqual(new Set(["lamp"]));
    expect(read(2, "", learnt)).toEqual(new Set(["lamp"]));
  });
});
