import "../style/path.css";
import { useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { isMoving } from "../drive/inputState";
import type { State } from "../state";
import { useState } from "../view/context";
import { STALE_MS } from "../view/live";
import { type Arc, arcOf, pathData } from "./arc";
import { commanded } from "./commanded";
import type { Ramp } from "./motion";
import { History, predict } from "./prediction";
import { aspectOf, drivingCamera } from "./view";

/** Redrawing the path faster than pictures arrive would be useless. */
const EVERY_MS = 32;
/** The delay besides the network's: half a set-point's period, and the server's loop. */
const HANDLING_MS = 20;

/**
 * Shows over the picture where the robot will be when a command arrives, and where it would stop.
 *
 * It fills the picture's box, and is drawn only while this page drives and the robot moves: the
 * lines' attributes are set in place, without rendering the page again.
 */
export function PathArc() {
  const state = useState();
  const svg = useRef<SVGSVGElement>(null);
  const painter = useRef<Painter | null>(null);
  useEffect(() => {
    painter.current = new Painter(state, (arc) => show(svg.current, arc));
    return () => painter.current?.stop();
  }, [state]);
  useSignalEffect(() => {
    const isMoved = state.mayMove.value && isMoving(state.motion.value);
    if (isMoved) painter.current?.start();
  });
  return (
    <svg
      ref={svg}
      class="path-arc"
      viewBox="0 0 100 100"
      preserveAspectRatio="none"
      aria-hidden="true"
    >
      <path class="path-seam" />
      <path class="path-lane" />
      <path class="path-arrival" />
      <path class="path-stand" />
    </svg>
  );
}

/** Draws while the robot moves, and stops by itself. */
class Painter {
  readonly #history = new History();
  #frame: number | null = null;
  #drawnMs = 0;

  constructor(
    private readonly state: State,
    private readonly show: (arc: Arc | null) => void,
  ) {}

  start(): void {
    if (this.#frame !== null) return;
    this.#history.clear();
    this.#next();
  }

  stop(): void {
    if (this.#frame !== null) cancelAnimationFrame(this.#frame);
    this.#frame = null;
    this.show(null);
  }

  #next(): void {
    this.#frame = requestAnimationFrame((nowMs) => this.#draw(nowMs));
  }

  #draw(nowMs: number): void {
    if (nowMs - this.#drawnMs < EVERY_MS) {
      this.#next();
      return;
    }
    this.#drawnMs = nowMs;
    const { facts, hello, mayMove, motion } = this.state;
    const robot = hello.peek()?.robot;
    const { pictureMs, roundTripMs } = facts.peek();
    if (!robot) {
      this.stop();
      return;
    }
    this.#history.note(nowMs, commanded(this.state), rampOf(robot.motion));
    const isKnown = pictureMs !== null && roundTripMs !== null && pictureMs < STALE_MS;
    const delays = {
      pictureMs: pictureMs ?? 0,
      commandMs: (roundTripMs ?? 0) / 2 + HANDLING_MS,
    };
    const prediction = predict(this.#history, nowMs, delays, robot.motion.braking_mps2);
    const isHeld = mayMove.peek() && isMoving(motion.peek());
    if (!prediction && !isHeld) {
      this.stop();
      return;
    }
    const camera = isKnown ? drivingCamera(this.state) : null;
    const arc =
      prediction && camera && arcOf(prediction, camera, aspectOf(this.state), robot.width_m);
    this.show(arc || null);
    this.#next();
  }
}

function rampOf(motion: { acceleration_mps2: number; acceleration_rps2: number }): Ramp {
  return {
    accelerationMps2: motion.acceleration_mps2,
    accelerationRps2: motion.acceleration_rps2,
  };
}

function show(svg: SVGSVGElement | null, arc: Arc | null): void {
  const [seam, lane, arrival, stand] = svg?.children ?? [];
  const lines = arc
    ? [arc.lanes.map(pathData).join(""), pathData(arc.arrival), pathData(arc.stand)]
    : ["", "", ""];
  draw(seam, lines.join(""));
  draw(lane, lines[0]);
  draw(arrival, lines[1]);
  draw(stand, lines[2]);
}

/** Sets the path's line, unless it is unchanged. */
function draw(path: Element | undefined, line = ""): void {
  if (path && path.getAttribute("d") !== line) path.setAttribute("d", line);
}
