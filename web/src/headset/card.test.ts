import { beforeEach, describe, expect, it } from "vitest";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { hello, pressedBy, room } from "../testing/messages";
import { says } from "../words/said";
import { loadLaterEnglish } from "../words/words";
import { cardWords, inTwo } from "./card";

let state: State;
const HELD = { isThere: true, isSqueezed: true, isReady: true };
const OPEN = { isThere: true, isSqueezed: false, isReady: false };

beforeEach(async () => {
  await loadLaterEnglish();
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: 1 });
  state.room.value = room({ operator: 1 });
  state.link.value = { is: "connected" };
  state.serverMs.value = 18_000;
  state.facts.value = { ...state.facts.value, pictureMs: 46 };
});

describe("who drives reads", () => {
  it("the turn, the seconds left, the delay and the speed", () => {
    const words = cardWords(state, HELD);
    expect(words).toMatchObject({ tone: "driving", headline: "You are driving" });
    expect(words.left).toBe(`${state.secondsLeft.value} s left`);
    expect(words.figures).toBe("Delay 46 ms · Slow");
  });

  it("how to drive, until something is held", () => {
    expect(cardWords(state, OPEN).next).toMatch(/^Keep a grip button squeezed/);
    expect(cardWords(state, HELD).next).toMatch(/^Keep a grip button squeezed/);
  });

  it("that bare hands cannot drive", () => {
    expect(cardWords(state, { ...OPEN, isThere: false }).next).toMatch(/^Pick up a controller/);
  });

  it("that the sticks must rest before they count", () => {
    expect(cardWords(state, { ...HELD, isReady: false }).next).toMatch(/^Let go/);
  });

  it("what limits the robot, and to how much", () => {
    state.isHolding.value = true;
    state.driveReason.value = { ...says("Slow: the picture is late."), values: {} } as never;
    state.driveShare.value = 0.5;
    const words = cardWords(state, HELD);
    expect(words.figures).toBe("Delay 46 ms · Slow · 50 %");
  });

  it("how to release a Stop", () => {
    state.room.value = { ...room({ operator: 1 }), stop: pressedBy("Cleo") };
    expect(cardWords(state, HELD)).toMatchObject({
      tone: "stopped",
      next: expect.stringMatching(/^Hold a trigger/),
    });
  });
});

it("says no delay while nothing arrives", () => {
  state.link.value = { is: "silent" } as never;
  expect(cardWords(state, HELD).figures).toMatch(/^Delay –/);
});

it("breaks a long text after the last word that fits", () => {
  const widthOf = (text: string) => text.length;
  expect(inTwo("one two", widthOf, 7)).toEqual(["one two"]);
  expect(inTwo("one two three", widthOf, 8)).toEqual(["one two", "three"]);
  expect(inTwo("uninterrupted", widthOf, 5)).toEqual(["uninterrupted", ""]);
});
