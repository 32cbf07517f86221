/** When a gamepad can be trusted, and counts as released; what follows: `gamepad.ts`. Pure. */

import type { Pad, PadReading } from "./padReading";

/** Longer than an axis that rests at an end takes to cross its middle. */
const STOOD_MS = 500;
/** A hand on a stick trembles; it is rarely still for this long. */
const STILL_MS = 1000;
const TREMBLE = 0.05;
/** A pad whose driver tool has closed repeats its last values; a held one changes sooner. */
export const FROZEN_MS = 10_000;
/** After this long without a reading, a release and a new push may have been missed. */
const LATE_MS = 250;

/**
 * Whether a gamepad has shown where it rests since it was chosen or its settings changed. Only a
 * standard layout promises that 0 is the middle. Pure: takes the time of each reading.
 */
export class PadRest {
  #readMs: number | null = null;
  #letGoMs: number | null = null;
  #still: readonly number[] = [];
  #stillMs = 0;
  #said = "";
  #saidMs = 0;
  #heard = new Set<number>();
  #hasStood = false;
  #moved = new Set<number>();
  #unmoved: readonly number[] = [];

  /** The axes with a stored rest that must still be moved and released. */
  get unmoved(): readonly number[] {
    return this.#hasStood ? this.#unmoved : [];
  }

  /**
   * Adds a reading; returns why the pad can no longer be trusted: it was read late, it is held but
   * has not changed for long, or an axis's first value is away from its rest.
   */
  doubt(pad: Pad, { held, axes }: PadReading, nowMs: number): "late" | "jumped" | "frozen" | null {
    const isLate = this.#readMs !== null && nowMs - this.#readMs > LATE_MS;
    this.#readMs = nowMs;
    if (isLate || held.length > 0) this.#letGoMs = null;
    else this.#letGoMs ??= nowMs;
    this.#hasStood ||= this.#stood(nowMs);

    const values = axes.map(({ value }) => value);
    const isStill = values.every((value, i) => Math.abs(value - (this.#still[i] ?? 0)) <= TREMBLE);
    if (isLate || !isStill || this.#still.length === 0)
      [this.#still, this.#stillMs] = [values, nowMs];

    const said = JSON.stringify([pad.axes, pad.buttons.map(({ value }) => value)]);
    if (isLate || said !== this.#said) [this.#said, this.#saidMs] = [said, nowMs];

    const isAside = (axis: number) => held.some(({ kind, at }) => kind === "axis" && at === axis);
    const isKnown = pad.mapping === "standard";
    let hasJumped = false;
    for (const { at, value, rest } of axes) {
      if (rest !== 0 && this.#hasStood && isAside(at)) this.#moved.add(at);
      // Some axes report exactly 0 until they are touched, and rest elsewhere.
      if (value === 0 || this.#heard.has(at)) continue;
      this.#heard.add(at);
      hasJumped ||= !isKnown && rest === 0 && isAside(at);
    }
    this.#unmoved = axes
      .filter(({ at, rest }) => rest !== 0 && !this.#moved.has(at))
      .map(({ at }) => at);
    if (isLate) return "late";
    if (hasJumped) return "jumped";
    return held.length > 0 && nowMs - this.#saidMs >= FROZEN_MS ? "frozen" : null;
  }

  /** Whether everything is released, as far as can be known. */
  isLetGo(pad: Pad, { held, axes }: PadReading, nowMs: number): boolean {
    const isPlain = pad.mapping === "standard" && axes.every(({ rest }) => rest === 0);
    if (isPlain) return held.length === 0;
    return this.#stood(nowMs) && this.#unmoved.length === 0;
  }

  /** Whether the axes that count have been still for a second. */
  isStill(nowMs: number): boolean {
    const isRead = this.#readMs !== null && nowMs - this.#readMs <= LATE_MS;
    return isRead && nowMs - this.#stillMs >= STILL_MS;
  }

  #stood(nowMs: number): boolean {
    return this.#letGoMs !== null && nowMs - this.#letGoMs >= STOOD_MS;
  }
}
