import { enlargement } from "../wantedSize";

const MAKES_KBPS = /at (\S+) kbit\/s$/;

/** After a change, measurements are ignored for this long. */
const SETTLES_MS = 2000;
/** More queueing delay, or more freezing in a second, than this means that the link is too thin. */
const QUEUE_MS = 250;
const FROZEN_MS = 200;
/** The better picture is tried after this long without; doubled after each failed try. */
const FIRST_CALM_MS = 5000;
const MOST_CALM_MS = 120_000;
/** A better picture that lasts this long counts as a success. */
const PROVEN_MS = 20_000;
/** The most by which the robot's clock and this page's drift apart. */
const DRIFT = 200e-6;

/** How a picture has arrived since the last measurement. */
export interface Arriving {
  /** From capture to arrival, by clocks with any offset; null if unknown. */
  delayMs: number | null;
  /** How long it was frozen. */
  frozenMs: number;
}

/** The publishers sorted by the rate in their names, the best first. */
export function inQuality(publishers: readonly string[]): string[] {
  const kbps = (name: string) => Number(MAKES_KBPS.exec(name)?.[1] ?? 0);
  return publishers.toSorted((a, b) => kbps(b) - kbps(a) || a.localeCompare(b));
}

/** The smallest picture of at least this size, or else the best; the best one comes first. Pure. */
export function enough(publishers: readonly string[], size: string): string | undefined {
  const [width = 0, height = 0] = size.split("x").map(Number);
  const fills = (name: string) => enlargement(name.split(" ")[1] ?? "", { width, height }) <= 1;
  return publishers.findLast(fills) ?? publishers[0];
}

/**
 * Whether this page's link is too thin for the better picture, judged by how it arrives: pictures
 * that queue arrive later and later, and those that do not fit are missing. Pure.
 */
export class RenditionChoice {
  #isSmall = false;
  #changedMs = Number.NEGATIVE_INFINITY;
  #calmSinceMs: number | null = null;
  #calmMs = FIRST_CALM_MS;
  #least: { delayMs: number; atMs: number } | null = null;
  #wasBad = false;

  get isSmall(): boolean {
    return this.#isSmall;
  }

  /** Adds a measurement, one or more a second. */
  add(arriving: Arriving, nowMs: number): void {
    if (nowMs - this.#changedMs < SETTLES_MS) return;
    const isBad =
      this.#queueMs(arriving.delayMs, nowMs) > QUEUE_MS || arriving.frozenMs > FROZEN_MS;
    const isSure = isBad && this.#wasBad;
    this.#wasBad = isBad;
    this.#calmSinceMs = isBad ? null : (this.#calmSinceMs ?? nowMs);
    const calmMs = this.#calmSinceMs === null ? 0 : nowMs - this.#calmSinceMs;
    if (this.#isSmall) {
      if (calmMs >= this.#calmMs) this.#change(false, nowMs);
    } else if (isSure) {
      this.#calmMs = Math.min(2 * this.#calmMs, MOST_CALM_MS);
      this.#change(true, nowMs);
    } else if (nowMs - this.#changedMs >= PROVEN_MS && calmMs >= PROVEN_MS) {
      this.#calmMs = FIRST_CALM_MS;
    }
  }

  /** Forgets the delays of the previous room, which do not apply to the next. */
  forget(): void {
    this.#least = null;
    this.#calmSinceMs = null;
    this.#wasBad = false;
  }

  #change(isSmall: boolean, nowMs: number): void {
    this.#isSmall = isSmall;
    this.#changedMs = nowMs;
    this.#calmSinceMs = null;
    this.#wasBad = false;
  }

  /** The queueing delay: how much later it arrives than at best. */
  #queueMs(delayMs: number | null, nowMs: number): number {
    if (delayMs === null) return 0;
    const least = this.#least;
    const bestMs = least ? least.delayMs + DRIFT * (nowMs - least.atMs) : delayMs;
    this.#least = { delayMs: Math.min(bestMs, delayMs), atMs: nowMs };
    return delayMs - this.#least.delayMs;
  }
}
