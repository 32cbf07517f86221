import { beforeEach, expect, it } from "vitest";
import { InputState } from "../drive/inputState";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { hello } from "../testing/messages";
import { Pan } from "./pan";

let state: State;
let input: InputState;
let pan: Pan;

beforeEach(() => {
  state = createState(loadPreferences(null));
  const greeting = hello();
  state.hello.value = { ...greeting, robot: { ...greeting.robot, axes: ["lift", "tilt", "pan"] } };
  input = new InputState({ changed: () => {}, deflected: () => {}, movesSideways: () => false });
  input.enable();
  pan = new Pan(state, {
    press: (holder, held) => input.press(holder, held),
    deflect: (holder, motion) => input.deflect(holder, motion),
    release: (holder) => input.release(holder),
    setAxis(name, position) {
      state.axes.value = { ...state.axes.peek(), [name]: position };
    },
  });
});

it("moves the camera's axes as fast as the stick is pushed, and moves no wheel", () => {
  pan.push({ left: 1, up: -0.5 }, 0.1);
  pan.push({ left: 1, up: -0.5 }, 0.1);
  expect(state.axes.value).toEqual({ pan: expect.closeTo(0.2), tilt: expect.closeTo(-0.1) });
  expect(input.isHolding).toBe(true);
  expect(input.motion).toEqual({ linear: 0, angular: 0 });
  pan.push({ left: 0, up: 0 }, 0.1);
  expect(input.isHolding).toBe(false);
});

it("stays within the axis", () => {
  for (let i = 0; i < 30; i++) pan.push({ left: 1, up: 0 }, 0.1);
  expect(state.axes.value).toEqual({ pan: 1 });
});

it("moves nothing more once something else has let go, until it is pushed again", () => {
  pan.push({ left: 1, up: 0 }, 0.1);
  input.releaseAll();
  pan.push({ left: 1, up: 0 }, 0.1);
  expect(state.axes.value).toEqual({ pan: expect.closeTo(0.1) });
  expect(input.isHolding).toBe(false);
  pan.push(null, 0.1);
  pan.push({ left: 1, up: 0 }, 0.1);
  expect(state.axes.value).toEqual({ pan: expect.closeTo(0.2) });
});
