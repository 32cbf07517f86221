import type { Drive } from "../messages";
import type { Motion } from "./hands";

/** What a set-point is made of, read live at the moment of sending. */
export interface Controls {
  motion: Motion;
  speed: Drive["speed"];
  axes: Record<string, number>;
}

export interface PumpOptions {
  controls: () => Controls;
  /** The time on the server's clock, null while the clocks are not aligned. */
  serverMs: () => number | null;
  /** Capture time of the newest presented picture. */
  seenServerMs: () => number | null;
  send: (drive: Drive, urgent: boolean) => void;
}

/** A release is said three times within 100 ms, since the channel may lose any of them. */
const AGAIN_AFTER_MS = [45, 90] as const;

/** Sends complete set-points at a steady rate while this page drives, and nothing otherwise. */
export class Pump {
  #seq = 0;
  #turn: number | null = null;
  #timer: ReturnType<typeof setInterval> | undefined;
  #repeats: ReturnType<typeof setTimeout>[] = [];

  constructor(private readonly options: PumpOptions) {}

  /** Sends for this turn from now on; the number goes with every command. */
  begin(turn: number, rateHz: number): void {
    this.end();
    this.#turn = turn;
    this.#timer = setInterval(() => this.send(), 1000 / rateHz);
    this.send();
  }

  end(): void {
    this.#turn = null;
    clearInterval(this.#timer);
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
  }

  /** Sends the set-point of this moment; called by the timer, and at once on every change. */
  send(urgent = false): void {
    const serverMs = this.options.serverMs();
    if (this.#turn === null || serverMs === null) return;
    const { motion, speed, axes } = this.options.controls();
    this.options.send(
      {
        type: "drive",
        seq: this.#seq++,
        turn: this.#turn,
        sent_server_ms: serverMs,
        ...motion,
        speed,
        seen_server_ms: this.options.seenServerMs(),
        axes,
      },
      urgent,
    );
  }

  /** Sends what is held after a release, now and again twice. */
  insist(): void {
    for (const timer of this.#repeats.splice(0)) clearTimeout(timer);
    this.send(true);
    this.#repeats = AGAIN_AFTER_MS.map((ms) => setTimeout(() => this.send(true), ms));
  }
}
