/** What a headset's controllers do, and what ends it; how they are read: `controllers.ts`. */

import { type ReadonlySignal, signal } from "@preact/signals";
import type { Session } from "../actions";
import { GamepadInput } from "../drive/gamepad";
import { listenLetGo } from "../drive/letGo";
import type { PadSettings } from "../drive/padReading";
import { HOLD_MS } from "../view/HoldButton";
import type { Grip } from "./card";
import { type Controller, Controllers } from "./controllers";
import { Pan } from "./pan";
import { SessionWindow } from "./sessionWindow";

/** The left stick moves, the right one turns. */
const HANDS = { turn: "right", planarTurn: "right", triggers: false } as const;

type Page = Pick<Session, "state" | "actions">;
type Worn = Pick<XRSession, "visibilityState" | "addEventListener"> & {
  readonly inputSources: Iterable<Controller>;
};

export interface Listening {
  seen: SessionWindow;
  grip: ReadonlySignal<Grip>;
  /** To be called in each frame, before it is drawn: only in frames do browsers read controllers. */
  frame: () => void;
}

/** Listens to the controllers, and to what ends input. */
export function listenHands(
  { state, actions }: Page,
  session: Worn,
  ended: AbortSignal,
): Listening {
  const controllers = new Controllers();
  let chosen = state.preferences.peek().gamepad;
  let settings: PadSettings = { ...chosen, ...HANDS };
  const settingsNow = () => {
    const now = state.preferences.peek().gamepad;
    if (now !== chosen) [chosen, settings] = [now, { ...now, ...HANDS }];
    return settings;
  };
  const seen = new SessionWindow(session, () => read().pad);
  const read = () => {
    const mayMove = state.mayMove.peek() && !seen.document.hidden;
    hands = controllers.read(session.inputSources, settingsNow(), mayMove);
    return hands;
  };
  let hands = controllers.read(session.inputSources, settings, false);
  let last = hands;
  const grip = signal<Grip>({ isThere: hands.isThere, isSqueezed: false, isReady: false });
  const pan = new Pan(state, actions);

  listenLetGo(seen.asWindow, { letGo: actions.letGo, lift: () => false, signal: ended });
  // Another gamepad would move the robot without the dead-man.
  const refusing = state.pads.subscribe(({ chosen }) => {
    if (chosen !== null) actions.useGamepad(null);
  });
  ended.addEventListener("abort", refusing);
  actions.enlarge(null);
  const input = new GamepadInput(seen.asWindow, {
    input: {
      // The dead-man: without it nothing is held, and the sticks must have rested since.
      get isEnabled() {
        return hands.isEnabling;
      },
      release: actions.release,
      deflect: actions.deflect,
    },
    ways: actions,
    operating: {
      press: actions.holdControl,
      release: actions.releaseControl,
      toggle: actions.toggleControl,
    },
    controls: () => state.usableControls.peek(),
    settings: settingsNow,
    movesSideways: () => state.movesSideways.peek(),
    // Each hand has a Stop of its own, which a gamepad has not: see `frame`.
    isDriving: () => false,
    stop: () => {},
    toggleSpeed: () =>
      actions.setSpeed(state.preferences.peek().speed === "slow" ? "fast" : "slow"),
    changed: ({ isReady }) => {
      grip.value = { ...grip.peek(), isReady };
      if (!isReady) pan.push(null, 0);
    },
    tell: () => {},
  });
  input.listen(ended);
  input.use(0);

  const answer = () => {
    if (state.callSecondsLeft.peek() !== null) actions.answerCall();
  };
  session.addEventListener("selectstart", answer);

  /** The Stop in force when a trigger was pressed, and when that was. */
  let releasing: { stop: number; sinceMs: number } | null = null;
  const holdToRelease = (nowMs: number) => {
    const stop = state.mayRelease.peek() ? state.stopNumber.peek() : null;
    if (!hands.isTriggered || stop === null) releasing = null;
    else if (!last.isTriggered) releasing = { stop, sinceMs: nowMs };
    // What was held unseen, or for another Stop, does not count.
    if (seen.document.hidden || releasing?.stop !== stop) releasing = null;
    if (!releasing || nowMs - releasing.sinceMs < HOLD_MS) return;
    releasing = null;
    actions.releaseStop();
  };

  let frameMs = performance.now();
  const frame = () => {
    const nowMs = performance.now();
    read();
    // Whoever watches can press Stop, too; one that is held does not keep the other from it.
    const isPressed = [...hands.stops].some((hand) => !last.stops.has(hand));
    if (isPressed && state.mayStop.peek()) actions.stop();
    holdToRelease(nowMs);
    const { isThere, isSqueezed } = hands;
    const before = grip.peek();
    if (isThere !== before.isThere || isSqueezed !== before.isSqueezed)
      grip.value = { ...before, isThere, isSqueezed };
    pan.push(before.isReady ? hands.pan : null, (nowMs - frameMs) / 1000);
    [last, frameMs] = [hands, nowMs];
  };
  return { seen, grip, frame };
}
