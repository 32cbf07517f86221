import { beforeEach, expect, it } from "vitest";
import { loadPreferences } from "./preferences";
import { createState, type State, secondsUntil } from "./state";
import { hello, pressedBy, room } from "./testing/messages";

let state: State;

beforeEach(() => {
  state = createState(loadPreferences(null));
  state.hello.value = hello({ viewer: 2 });
  state.link.value = { is: "connected" };
});

it("drives with the turn's number only while the turn is its own and the link is up", () => {
  state.room.value = room({ operator: 1, waiting: [2] });
  expect(state.drivingTurn.value).toBeNull();
  state.room.value = room({ operator: 2, number: 9 });
  expect(state.drivingTurn.value).toBe(9);
  state.link.value = { is: "connecting", reason: null };
  expect(state.drivingTurn.value).toBeNull();
});

it("still drives while no answer arrives, as only the server knows whether anything moves", () => {
  state.room.value = room({ operator: 2, number: 9 });
  state.link.value = { is: "silent", sinceMs: 0 };
  expect(state.drivingTurn.value).toBe(9);
  expect(state.isConnected.value).toBe(true);
  expect(state.isSilent.value).toBe(true);
});

it("does not drive when nobody does", () => {
  state.hello.value = null;
  state.room.value = room({});
  expect(state.drivingTurn.value).toBeNull();
});

it("finds itself and the operator in the room state", () => {
  state.room.value = room({ operator: 1, waiting: [2] });
  expect(state.me.value?.place).toBe(1);
  expect(state.operator.value?.id).toBe(1);
});

it("counts the seconds left on the server's clock", () => {
  state.room.value = room({ operator: 1, endsMs: 60_000 });
  expect(state.secondsLeft.value).toBeNull();
  state.serverMs.value = 17_500;
  expect(state.secondsLeft.value).toBe(43);
});

it("never shows more than a turn, nor less than zero", () => {
  expect(secondsUntil(60_050, 0, 60)).toBe(60);
  expect(secondsUntil(1, 0, 60)).toBe(1);
  expect(secondsUntil(0, 0, 60)).toBe(0);
  expect(secondsUntil(0, 5000, 60)).toBe(0);
});

it("offers the release of a stop to those who may release it", () => {
  const offers = (by_host: boolean, is_host: boolean, operator: number) => {
    state.hello.value = hello({ viewer: 2, is_host });
    const stop = pressedBy("Eve", { by_host });
    const watching = operator === 2 ? [] : [2];
    state.room.value = room({ operator, watching, stop });
    return state.mayRelease.value;
  };
  expect(offers(false, false, 2)).toBe(true);
  expect(offers(true, false, 2)).toBe(false);
  expect(offers(true, true, 1)).toBe(true);
  expect(offers(false, false, 1)).toBe(false);
});
