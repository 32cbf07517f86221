/** Gaps, freezes and delays from what the players count; ages: `picture.ts`, `sound.ts`. */

import type { PictureReport, SoundReport } from "../messages";
import type { Heard } from "../sound/builtInPlayer";
import { LastMinute } from "./breaks";
import type { Freezes } from "./freezes";
import { DelayMeter } from "./meanDelay";
import type { ReceiverStats } from "./stats";
import { Tally } from "./tally";

/** Shorter gaps are hardly audible. */
const PAUSE_MS = 30;

/** What is measured besides the age, by either player. */
type SoundFigures = Omit<SoundReport, "age_ms" | "player">;

/** The sound's figures from the receiver's counters, or from the built-in player. */
export class SoundCounts {
  readonly pauses = new LastMinute(PAUSE_MS);
  readonly #buffer = new DelayMeter();
  readonly #output = new DelayMeter();
  readonly #tally = new Tally("concealed", "events", "played", "stretched");
  #concealedMs = 0;

  /** Pauses counting while the sound is off. */
  rest(): void {
    this.#tally.rest();
  }

  /**
   * Returns everything but the age. Concealed samples include silent ones, which browsers insert in
   * long gaps, the worst of all. The device's delay (`output_ms`) is null in browsers without
   * `media-playout`.
   */
  next({ inbound, playout, clockHz }: ReceiverStats, nowMs: number): SoundFigures {
    const toMs = 1000 / clockHz;
    const { packetsReceived, concealedSamples, concealmentEvents, totalSamplesReceived } = inbound;
    const isCounted = packetsReceived !== undefined && concealedSamples !== undefined;
    if (isCounted) {
      const risen = this.#tally.add(packetsReceived, {
        concealed: concealedSamples,
        events: concealmentEvents ?? 0,
        played: totalSamplesReceived ?? 0,
        stretched: inbound.insertedSamplesForDeceleration ?? 0,
      });
      this.pauses.add(nowMs, risen.events, risen.concealed * toMs);
    }
    const { total } = this.#tally;
    return {
      delay_ms: this.#buffer.next(inbound.jitterBufferDelay, inbound.jitterBufferEmittedCount),
      output_ms: this.#output.next(playout.totalPlayoutDelay, playout.totalSamplesCount),
      concealed_ms: isCounted ? total.concealed * toMs : null,
      played_ms: isCounted ? total.played * toMs : null,
      stretched_ms: isCounted ? total.stretched * toMs : null,
    };
  }

  /** Returns the same figures for the built-in player. */
  builtIn(
    { delayMs, outputMs, concealedMs, playedMs, stretchedMs }: Heard,
    nowMs: number,
  ): SoundFigures {
    const riseMs = concealedMs - this.#concealedMs;
    if (riseMs > 0) this.pauses.add(nowMs, 1, riseMs);
    this.#concealedMs = concealedMs;
    return {
      delay_ms: delayMs,
      output_ms: outputMs,
      concealed_ms: concealedMs,
      played_ms: playedMs,
      stretched_ms: stretchedMs,
    };
  }
}

/** The picture's figures from the receiver's counters, or from `seen` if the browser lacks them. */
export class PictureCounts {
  readonly freezes = new LastMinute(0);
  readonly #buffer = new DelayMeter();
  readonly #tally = new Tally("freezes", "frozenMs");

  /** Pauses counting while the picture is off or not visible. */
  rest(): void {
    this.#tally.rest();
  }

  next(
    { inbound }: ReceiverStats,
    seen: Freezes,
    nowMs: number,
  ): Pick<PictureReport, "delay_ms" | "frozen_ms"> {
    const { framesDecoded, freezeCount, totalFreezesDuration } = inbound;
    const isCounted = freezeCount !== undefined && totalFreezesDuration !== undefined;
    const risen = this.#tally.add(framesDecoded ?? 0, {
      freezes: isCounted ? freezeCount : seen.count,
      frozenMs: isCounted ? totalFreezesDuration * 1000 : seen.totalMs,
    });
    this.freezes.add(nowMs, risen.freezes, risen.frozenMs);
    return {
      delay_ms: this.#buffer.next(inbound.jitterBufferDelay, inbound.jitterBufferEmittedCount),
      frozen_ms: this.#tally.total.frozenMs,
    };
  }
}
