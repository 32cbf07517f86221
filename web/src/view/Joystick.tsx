import { useSignal, useSignalEffect } from "@preact/signals";
import type { TargetedPointerEvent } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { Deflection } from "../drive/deflection";
import { fingerHolder } from "../drive/inputState";
import { deflectionAt, motionOf, type Place, type StickUse } from "../drive/stick";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { TurnIcon } from "./icons";

type Pointer = TargetedPointerEvent<HTMLDivElement>;

declare module "preact" {
  interface DOMAttributes<Target extends EventTarget> {
    /** Pointer Events, level 3, which not every browser has. */
    onPointerRawUpdate?: (event: TargetedPointerEvent<Target>) => void;
  }
}

/** The knob's travel and width as shares of the whole: see joystick.css. */
const TRAVEL = 0.35;
const KNOB: Record<StickUse, number> = { drive: 0.44, move: 0.44, turn: 0.3 };
const MIDDLE: Deflection = { x: 0, y: 0 };

/**
 * An analogue stick for one finger or the mouse; one that only turns goes only left and right. It
 * is held while touched, moves the robot in proportion to its distance from where it was touched,
 * and springs back when released. So a thumb that lands off-centre, or a page that moves under it,
 * moves nothing. Arrow keys drive while it has the focus, as everywhere on the page.
 */
export function Joystick({ use }: { use: StickUse }) {
  const { mayMove, isHolding } = useState();
  const { press, deflect, release, letGo } = useActions();
  const knob = useSignal(MIDDLE);
  /** The finger on the stick, and where it touched down, which is the middle. */
  const grip = useRef<{ pointerId: number; place: Place } | null>(null);

  const end = () => {
    grip.current = null;
    knob.value = MIDDLE;
  };
  // Show the knob released, whatever has released it.
  useSignalEffect(() => {
    if (!isHolding.value) knob.value = MIDDLE;
  });
  useEffect(
    () => () => {
      if (grip.current) release(fingerHolder(grip.current.pointerId));
    },
    [release],
  );

  const onPointerDown = (event: Pointer) => {
    // Prevent the focus, which a finger does not need, and a text selection.
    event.preventDefault();
    if (event.button !== 0 || grip.current || !mayMove.peek()) return;
    const { pointerId, clientX, clientY, currentTarget } = event;
    currentTarget.setPointerCapture(pointerId);
    const radius = currentTarget.getBoundingClientRect().width * TRAVEL;
    grip.current = { pointerId, place: { x: clientX, y: clientY, radius } };
    press(fingerHolder(pointerId), motionOf(MIDDLE, use));
  };
  const onPointerMove = (event: Pointer) => {
    if (grip.current?.pointerId !== event.pointerId) return;
    const at = deflectionAt(grip.current.place, event.clientX, event.clientY, use);
    if (deflect(fingerHolder(event.pointerId), motionOf(at, use))) knob.value = at;
    else end();
  };
  const onPointerUp = (event: Pointer) => {
    if (grip.current?.pointerId !== event.pointerId) return;
    end();
    release(fingerHolder(event.pointerId));
  };
  // After an ordinary release nothing is held: anything still held was cancelled by the system.
  const onLost = (event: Pointer) => {
    if (grip.current?.pointerId !== event.pointerId) return;
    end();
    if (release(fingerHolder(event.pointerId))) letGo();
  };

  const { x, y } = knob.value;
  const percent = (share: number) => `${((share * TRAVEL) / KNOB[use]) * 100}%`;
  const help = use === "turn" ? "turn-help" : "joystick-help";
  return (
    <div
      class={`joystick is-${use}${x === 0 && y === 0 ? "" : " is-held"}`}
      role="application"
      aria-label={t(use === "turn" ? "ways.turn_stick" : "ways.joystick")}
      aria-describedby={help}
      aria-disabled={!mayMove.value}
      // biome-ignore lint/a11y/noNoninteractiveTabindex: arrow keys drive while it has the focus
      tabIndex={0}
      onPointerDown={onPointerDown}
      // Where supported, it reports a move at once; `pointermove` reports it with the next frame.
      onPointerRawUpdate={onPointerMove}
      onPointerMove={onPointerMove}
      onPointerUp={onPointerUp}
      onPointerCancel={onLost}
      onLostPointerCapture={onLost}
      onMouseDown={(event) => event.preventDefault()}
      // A long touch opens a menu on some phones.
      onContextMenu={(event) => {
        event.preventDefault();
        event.stopPropagation();
      }}
    >
      {use === "turn" && <TurnIcon />}
      <span
        class="joystick-knob"
        aria-hidden="true"
        style={{ translate: `${percent(x)} ${percent(y)}` }}
      />
      {use === "turn" && <TurnIcon />}
      <span id={help} hidden>
        {t(use === "turn" ? "ways.turn_stick_help" : "ways.joystick_help")}
      </span>
    </div>
  );
}
