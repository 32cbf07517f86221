/** What a headset's controllers do, and what ends it; how they are read: `controllers.ts`. */

import { signal } from "@preact/signals";
import type { Session } from "../actions";
import { GamepadInput } from "../drive/gamepad";
import { listenLetGo } from "../drive/letGo";
import type { PadSettings } from "../drive/padReading";
import { HOLD_MS } from "../view/HoldButton";
import type { Grip } from "./card";
import { type Controller, Controllers } from "./controllers";
import { Pan } from "./pan";
import { SessionWindow } from "./sessionWindow";

type Page = Pick<Session, "state" | "actions">;
type Worn = Pick<XRSession, "visibilityState" | "addEventListener"> & {
  readonly inputSources: Iterable<Controller>;
};

/** The left stick moves, the right one turns. */
const HANDS = { turn: "right", planarTurn: "right", triggers: false } as const;

/** Listens to the controllers, and to what ends input. */
export function listenHands({ state, actions }: Page, session: Worn, ended: AbortSignal) {
  const controllers = new Controllers();
  let chosen = state.preferences.peek().gamepad;
  let settings: PadSettings = { ...chosen, ...HANDS };
  const settingsNow = () => {
    const now = state.preferences.peek().gamepad;
    if (now !== chosen) [chosen, settings] = [now, { ...now, ...HANDS }];
    return settings;
  };
  const read = () => controllers.read(session.inputSources, settingsNow());
  let hands = read();
  const seen = new SessionWindow(session, () => {
    hands = read();
    return hands.pad;
  });
  const grip = signal<Grip>({ isSqueezed: false, isReady: false });
  const pan = new Pan(state, actions);

  listenLetGo(seen.asWindow, { letGo: actions.letGo, lift: () => false, signal: ended });
  // Another gamepad would move the robot without the dead-man.
  actions.useGamepad(null);
  actions.enlarge(null);
  const input = new GamepadInput(seen.asWindow, {
    input: {
      // The dead-man: without it nothing is held, and the sticks must have rested since.
      get isEnabled() {
        return state.mayMove.peek() && hands.isSqueezed;
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
    // Who watches can press Stop, too.
    isDriving: () => state.mayStop.peek(),
    stop: actions.stop,
    toggleSpeed: () =>
      actions.setSpeed(state.preferences.peek().speed === "slow" ? "fast" : "slow"),
    changed: ({ isReady }) => {
      grip.value = { ...grip.peek(), isReady };
    },
    tell: () => {},
  });
  input.listen(ended);
  input.use(0);

  let release: ReturnType<typeof setTimeout> | undefined;
  const isStopped = () => state.stopNumber.peek() !== null && state.mayRelease.peek();
  session.addEventListener("selectstart", () => {
    if (state.callSecondsLeft.peek() !== null) actions.answerCall();
    if (isStopped()) release = setTimeout(() => isStopped() && actions.releaseStop(), HOLD_MS);
  });
  for (const type of ["selectend", "visibilitychange", "end"]) {
    session.addEventListener(type, () => clearTimeout(release));
  }
  const frame = (seconds: number) => {
    const { isSqueezed } = hands;
    if (isSqueezed !== grip.peek().isSqueezed) grip.value = { ...grip.peek(), isSqueezed };
    pan.push(grip.peek().isReady ? hands.pan : null, seconds);
  };
  return { seen, hold: { grip, frame } };
}
