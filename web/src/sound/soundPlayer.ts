/** Plays, faster or slower, and conceals missing sound; how late: `delayTarget.ts`. Pure. */

import { DelayTarget } from "./delayTarget";
import { OPUS_HZ } from "./opus";
import { COMPARED, LONGEST, periodBefore } from "./period";
import { Ring, type Side } from "./ring";

/** What was played since the start, in samples. */
export interface Played {
  played: number;
  /** Missing sound, concealed by repeating what came before. */
  concealed: number;
  /** Periods that were played twice, to wait for overdue sound. */
  stretched: number;
  /** Periods that were skipped, to catch up. */
  dropped: number;
}

const SIDES: readonly Side[] = [0, 1];
const MS = OPUS_HZ / 1000;
/** How many following samples the interpolation needs. */
const REACH = 3;
/** The length of a crossfade. */
const FADE = 5 * MS;
/** The largest change of the playing rate, which is inaudible. */
const MOST_RATE = 0.005;
/** The change of rate per sample off the target: 0.0005 per millisecond. */
const RATE_PER_SAMPLE = 0.0005 / MS;
/** Farther behind than this, whole periods are skipped: the rate alone would be too slow. */
const FAR_BEHIND = 20 * MS;
/** The pause between two such periods; the farther behind, the shorter. */
const CUT_EVERY = 100 * MS;
/** Farther behind than this, playing jumps to the target, with an audible break. */
const LOST_BEHIND = 400 * MS;
/** How long overdue sound is waited for, repeating periods; then playing moves on without it. */
const MOST_WAIT = 60 * MS;
/** The newest judgement's share in the moving average. */
const NEW_SHARE = 1 / 8;
/** Concealment keeps its level until `LOUD`, then fades out until `SILENT`. */
const LOUD = 20 * MS;
const SILENT = 80 * MS;
/** After this long without sound, whatever arrives is played, however late. */
const GIVEN_UP = 400 * MS;
/** Arbitrary; leaves room for packets older than the first. */
const ORIGIN = OPUS_HZ;
/** A packet farther than this from the newest sound is from another sender. */
const ANEW = 2 * OPUS_HZ;

/**
 * Plays decoded packets, each as late as its link demands and no later.
 *
 * Its only clock is the device's: `frame` counts the samples that the device has taken. Call
 * `arrive` when a packet has been decoded, and `render` for each block that the device takes.
 * Nothing is played twice or out of order except the periods that `Played` counts. Pure.
 */
export class SoundPlayer {
  readonly counts: Played = { played: 0, concealed: 0, stretched: 0, dropped: 0 };
  readonly #ring = new Ring();
  readonly #target = new DelayTarget();
  readonly #repeated = [new Float32Array(LONGEST), new Float32Array(LONGEST)] as const;
  /** The sum of both ears, to find periods that fit both. */
  readonly #sum = (time: number) => this.#ring.at(time, 0) + this.#ring.at(time, 1);
  /** The next sample for both ears. */
  readonly #pair = [0, 0] as [left: number, right: number];
  /** The RTP time of the ring's `ORIGIN`. */
  #rtpOrigin: number | null = null;
  /** The next position, in the ring's time; null until playing starts. */
  #position: number | null = null;
  /** The position that is fading out, in the ring's time, with `#fading` samples left. */
  #leaving = 0;
  #fading = 0;
  #isConcealing = false;
  #concealed = 0;
  /** Where the concealment began, in the ring's time; nothing after it has been played. */
  #heardEnd = 0;
  #period = 1;
  #waited = 0;
  /** Where the sound ran out; null once that has been judged. */
  #dry: number | null = null;
  /** The share of recent gaps that were late; the rest were lost. */
  #late = 1;
  /** How late the current block plays. */
  #behind = 0;
  #cutAt = Number.NEGATIVE_INFINITY;
  #least: number | null = null;

  /** The minimum delay after the fastest packet; null for what the link demands. */
  set leastDelayMs(ms: number | null) {
    this.#least = ms === null ? null : ms * MS;
  }

  /**
   * Adds a decoded packet: one channel for both ears, or the left and the right one. `rtp` is the
   * time of its first sample.
   */
  arrive(rtp: number, [left, right]: readonly Float32Array[], frame: number): void {
    if (!left) return;
    this.#rtpOrigin ??= rtp;
    let time = ORIGIN + ((rtp - this.#rtpOrigin) | 0);
    if (time % 120 !== 0 || Math.abs(time - Math.max(this.#ring.end, ORIGIN)) > ANEW) {
      this.restart();
      this.#rtpOrigin = rtp;
      time = ORIGIN;
    }
    this.#ring.write(time, left, right);
    this.#judge();
    if (this.#isSilent && time >= this.#heardEnd && time < (this.#position ?? time)) {
      // The link's delay has grown beyond what is waited for: continue with what arrives now.
      this.#target.clear();
      this.#position = time;
    }
    this.#target.add(frame - time, frame);
  }

  /** Starts over with the next packet, because the device has stalled or the sender has changed. */
  restart(): void {
    this.#ring.clear();
    this.#target.clear();
    this.#rtpOrigin = null;
    this.#position = null;
    this.#fading = 0;
    this.#isConcealing = false;
    this.#waited = 0;
    this.#dry = null;
    this.#late = 1;
  }

  /** The RTP time of the next sample; null while silent or concealing. */
  get rtp(): number | null {
    if (this.#position === null || this.#rtpOrigin === null || this.#isConcealing) return null;
    return (this.#rtpOrigin + Math.round(this.#position) - ORIGIN) >>> 0;
  }

  /** How much sound is buffered ahead. */
  get aheadMs(): number {
    return this.#position === null ? 0 : Math.max(0, this.#ring.end - this.#position) / MS;
  }

  /** Fills the channels with what plays from `frame` on; a single channel gets the left ear. */
  render([left, right]: readonly Float32Array[], frame: number): void {
    if (!left) return;
    const due = frame - this.#delay(frame);
    if (this.#rtpOrigin === null || (this.#position === null && !this.#begins(due))) {
      left.fill(0);
      right?.fill(0);
      return;
    }
    const position = this.#position ?? due;
    const behind = due - position;
    this.#behind = behind;
    if (behind > LOST_BEHIND) this.#jump(due);
    else if (behind > FAR_BEHIND) this.#cut(frame);
    const rate = 1 + Math.min(Math.max(behind * RATE_PER_SAMPLE, -MOST_RATE), MOST_RATE);
    for (let i = 0; i < left.length; i++) {
      this.#next(rate);
      left[i] = this.#pair[0];
      if (right) right[i] = this.#pair[1];
    }
    this.counts.played += left.length;
  }

  /** Whether nothing has arrived in time for longer than a stall lasts. */
  get #isSilent(): boolean {
    return this.#isConcealing && this.#concealed >= GIVEN_UP;
  }

  #delay(frame: number): number {
    const delay = this.#target.at(frame);
    return this.#least === null ? delay : Math.max(delay, this.#target.least + this.#least);
  }

  #begins(due: number): boolean {
    if (due < ORIGIN || !this.#ring.has(due, due + 1)) return false;
    this.#position = due;
    this.#leaving = -ORIGIN; // fade in from silence
    this.#fading = FADE;
    return true;
  }

  /** Computes the next sample for both ears, and advances. */
  #next(rate: number): void {
    const position = this.#position ?? 0;
    if (this.#ring.has(position, position + REACH)) {
      if (this.#isConcealing) this.#resume();
      this.#waited = 0;
      this.#position = position + rate;
      this.#draw(position, rate);
      return;
    }
    if (!this.#isConcealing) this.#conceal(position);
    const isHole = this.#ring.end > position + REACH;
    if (isHole && this.#skip(position)) {
      this.#next(rate);
      return;
    }
    if (isHole || this.#waited >= MOST_WAIT || this.#late < 0.5) {
      this.#position = position + rate;
      this.counts.concealed++;
    } else {
      // The position stays, so that the overdue sound is played whole.
      this.#waited++;
      this.counts.stretched++;
    }
    for (const side of SIDES) this.#pair[side] = this.#invented(side);
    this.#concealed++;
  }

  /** Decides, once more sound has arrived, whether the sound that ran out was late or lost. */
  #judge(): void {
    if (this.#dry === null || this.#ring.end <= this.#dry + REACH) return;
    const isLate = this.#ring.has(this.#dry, this.#dry + REACH);
    this.#late += ((isLate ? 1 : 0) - this.#late) * NEW_SHARE;
    this.#dry = null;
  }

  #conceal(position: number): void {
    if (this.#ring.end <= position + REACH) this.#dry = position;
    this.#isConcealing = true;
    this.#concealed = 0;
    this.#heardEnd = position;
    const end = Math.floor(position);
    this.#period = periodBefore(this.#sum, end);
    for (const side of SIDES) {
      const repeated = this.#repeated[side];
      for (let i = 0; i < this.#period; i++) {
        repeated[i] = this.#ring.at(end - this.#period + i, side);
      }
    }
  }

  #invented(side: Side): number {
    const gain = Math.min(1, Math.max(0, (SILENT - this.#concealed) / (SILENT - LOUD)));
    return gain * (this.#repeated[side][this.#concealed % this.#period] ?? 0);
  }

  /** Skips missing sound instead of concealing it, if playing is behind by at least as much. */
  #skip(position: number): boolean {
    const next = this.#ring.nextFrom(position + REACH);
    const missing = next - position;
    if (missing > this.#behind - FAR_BEHIND) return false;
    this.#behind -= missing;
    this.#position = next;
    return true;
  }

  /** Ends the concealment with a crossfade into the sound that has arrived. */
  #resume(): void {
    this.#isConcealing = false;
    this.#fading = FADE;
    this.#leaving = Number.NaN;
  }

  /** Reads both ears at this position, with any crossfade in progress. */
  #draw(position: number, rate: number): void {
    for (const side of SIDES) this.#pair[side] = this.#ring.between(position, side);
    if (this.#fading === 0) return;
    const share = this.#fading-- / FADE;
    const isConcealing = Number.isNaN(this.#leaving);
    for (const side of SIDES) {
      const leaving = isConcealing ? this.#invented(side) : this.#ring.between(this.#leaving, side);
      this.#pair[side] = leaving * share + this.#pair[side] * (1 - share);
    }
    if (isConcealing) this.#concealed++;
    else this.#leaving += rate;
  }

  /** Skips one period, if enough sound is buffered. */
  #cut(frame: number): void {
    const position = this.#position ?? 0;
    const everyFrames = CUT_EVERY * (FAR_BEHIND / this.#behind);
    if (this.#fading > 0 || this.#isConcealing || frame - this.#cutAt < everyFrames) return;
    const from = Math.floor(position);
    const period = periodBefore(this.#sum, from + LONGEST + COMPARED);
    if (!this.#ring.has(position, position + LONGEST + COMPARED)) return;
    if (!this.#ring.has(position, position + period + 2 * FADE)) return;
    this.#cutAt = frame;
    this.#leaving = position;
    this.#fading = FADE;
    this.#position = position + period;
    this.counts.dropped += period;
  }

  #jump(due: number): void {
    const position = this.#position ?? due;
    this.counts.dropped += due - position;
    this.#leaving = position;
    this.#fading = FADE;
    this.#position = due;
    this.#isConcealing = false;
  }
}
