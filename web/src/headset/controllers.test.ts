import { describe, expect, it } from "vitest";
import { readPad } from "../drive/padReading";
import { loadPreferences } from "../preferences";
import { type Controller, Controllers } from "./controllers";

const response = { deadZone: 0.1, curve: 1 };
const TRIGGER = 0;
const SQUEEZE = 1;

/** A Touch controller that nobody touches, but for these. */
function hand(
  handedness: XRHandedness,
  more: { stick?: number[]; axes?: number[]; pressed?: number[]; buttons?: number } = {},
): Controller {
  const { stick = [0, 0], axes = [0, 0, ...stick], pressed = [], buttons = 7 } = more;
  const button = (at: number) => ({
    pressed: pressed.includes(at),
    value: Number(pressed.includes(at)),
  });
  return {
    handedness,
    gamepad: {
      id: "",
      mapping: "xr-standard",
      axes,
      buttons: Array.from({ length: buttons }, (_, at) => button(at)),
    },
  };
}

/** Reads these hands after others that hold nothing. */
function read(...all: Controller[]) {
  const controllers = new Controllers();
  const open = all.map(({ handedness }) => hand(handedness));
  controllers.read(open, response, true);
  controllers.read(open, response, true);
  return controllers.read(all, response, true);
}
/** As `gamepad.ts` reads the pad, on a robot that moves sideways. */
const reading = (...all: Controller[]) => {
  const settings = { ...loadPreferences(null).gamepad, ...response };
  const hands = { turn: "right", planarTurn: "right", triggers: false } as const;
  return readPad(read(...all).pad, { ...settings, ...hands }, true);
};

describe("the sticks", () => {
  it("move with the left one and turn with the right one", () => {
    const { motion } = reading(
      hand("left", { stick: [0, -1] }),
      hand("right", { stick: [-1, 0.5] }),
    );
    expect(motion).toEqual({ linear: 1, angular: 1, lateral: expect.closeTo(0) });
    expect(reading(hand("left", { stick: [-1, 0] })).motion.lateral).toBe(1);
  });

  it("are a touch pad where there is no stick", () => {
    expect(reading(hand("left", { axes: [0, -1], buttons: 3 })).motion.linear).toBe(1);
  });

  it("count only on the hand that holds them", () => {
    const { pad } = read(hand("none", { stick: [1, 1] }), { handedness: "left" });
    expect(pad.axes.slice(0, 4)).toEqual([0, 0, 0, 0]);
  });
});

describe("the dead-man", () => {
  it.each(["left", "right"] as const)("is the squeeze of the %s hand", (handedness) => {
    expect(read(hand(handedness)).isEnabling).toBe(false);
    expect(read(hand(handedness, { pressed: [SQUEEZE] })).isEnabling).toBe(true);
  });

  const squeezed = [hand("left", { pressed: [SQUEEZE] }), hand("right")];
  const open = [hand("left"), hand("right")];

  it.each([
    ["begins", []],
    [
      "could not be moved for a moment",
      [
        [open, true],
        [squeezed, true],
        [squeezed, false],
      ],
    ],
    [
      "had lost a controller",
      [
        [open, true],
        [squeezed, true],
        [[squeezed[0]], true],
      ],
    ],
  ] as const)("needs a new squeeze when driving %s", (_, before) => {
    const controllers = new Controllers();
    for (const [all, mayMove] of before) controllers.read(all as Controller[], response, mayMove);
    const now = (all: Controller[]) => controllers.read(all, response, true);
    expect(now(squeezed)).toMatchObject({ isEnabling: false, isSqueezed: true });
    expect(now(squeezed).isEnabling).toBe(false);
    now(open);
    expect(now(squeezed).isEnabling).toBe(true);
  });

  it("is not a controller's that has no button for Stop", () => {
    const bare = read(hand("right", { pressed: [SQUEEZE], buttons: 2 }), { handedness: "left" });
    expect(bare).toMatchObject({ isThere: false, isSqueezed: false });
  });
});

describe("Stop", () => {
  it.each([
    ["left", 7, 5],
    ["right", 7, 5],
    ["right", 5, 4],
    ["left", 4, 3],
    ["right", 3, 2],
  ] as const)("is a button of the %s hand, of %i buttons the one at %i", (on, buttons, at) => {
    expect(reading(hand(on, { buttons })).stop).toBe(false);
    const { stop, speed } = reading(hand(on, { buttons, pressed: [at] }));
    expect([stop, speed]).toEqual([true, false]);
  });

  it("is not the trigger, the squeeze, or A, which changes the speed", () => {
    const { stop, speed } = reading(hand("right", { pressed: [TRIGGER, SQUEEZE, 4] }));
    expect([stop, speed]).toEqual([false, true]);
  });
});

describe("the right stick with its trigger", () => {
  const aside = { stick: [-1, -0.55] };

  it("pans in place of turning, only while a grip is squeezed", () => {
    const pulled = hand("right", { ...aside, pressed: [TRIGGER] });
    expect(read(pulled).pan).toBeNull();
    const held = read(pulled, hand("left", { pressed: [SQUEEZE] }));
    expect(held.pan).toEqual({ left: 1, up: expect.closeTo(0.5) });
    expect(held.pad.axes.slice(2, 4)).toEqual([0, 0]);
  });

  it("does not turn the robot when the trigger is released first", () => {
    const controllers = new Controllers();
    const now = (one: Controller) => controllers.read([one], response, true);
    const say = (...pressed: number[]) =>
      now(hand("right", { ...aside, pressed: [SQUEEZE, ...pressed] }));
    say(TRIGGER);
    expect(say().pad.axes[2]).toBe(0);
    now(hand("right", { pressed: [SQUEEZE] }));
    expect(say().pad.axes[2]).toBe(-1);
    expect(say().pan).toBeNull();
  });
});
