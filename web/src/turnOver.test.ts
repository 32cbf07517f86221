import { signal } from "@preact/signals";
import { beforeEach, expect, it, vi } from "vitest";
import { loadPreferences } from "./preferences";
import { createState, type State } from "./state";
import { listenTurnOver } from "./turnOver";

let state: State;
const turn = signal<number | null>(null);
const isConnected = signal(true);

beforeEach(() => {
  vi.useFakeTimers();
  turn.value = null;
  isConnected.value = true;
  state = { ...createState(loadPreferences(null)), drivingTurn: turn, isConnected };
  listenTurnOver(state);
});

it("thanks for a while after a turn has ended", () => {
  turn.value = 4;
  expect(state.isTurnJustOver.value).toBe(false);
  turn.value = null;
  expect(state.isTurnJustOver.value).toBe(true);
  vi.advanceTimersByTime(12_000);
  expect(state.isTurnJustOver.value).toBe(false);
});

it("does not thank after a lost connection, or while the user drives again", () => {
  turn.value = 4;
  isConnected.value = false;
  turn.value = null;
  expect(state.isTurnJustOver.value).toBe(false);
  isConnected.value = true;
  turn.value = 5;
  turn.value = null;
  turn.value = 6;
  expect(state.isTurnJustOver.value).toBe(false);
});

it("lets the user disown a turn for a minute, even if a lost connection has ended it", () => {
  isConnected.value = false;
  turn.value = 4;
  expect(state.drivenTurn.value).toBeNull();
  turn.value = null;
  expect(state.drivenTurn.value).toBe(4);
  vi.advanceTimersByTime(60_000);
  expect(state.drivenTurn.value).toBeNull();
  turn.value = 5;
  turn.value = null;
  turn.value = 6;
  expect(state.drivenTurn.value).toBeNull();
  turn.value = 7;
  expect(state.drivenTurn.value).toBeNull();
});
