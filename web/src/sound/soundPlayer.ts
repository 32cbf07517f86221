/** Plays, faster or slower, and conceals what has not come; how late: `delayTarget.ts`. Pure. */

import { DelayTarget } from "./delayTarget";
import { OPUS_HZ } from "./opus";
import { COMPARED, LONGEST, periodBefore } from "./period";
import { Ring, type Side } from "./ring";

/** What was played since the beginning, in samples. */
export interface Played {
  played: number;
  /** What had not come, and was concealed by what came before. */
  concealed: number;
  /** Periods that were played twice, to wait for what is overdue. */
  stretched: number;
  /** Periods that were left out, to catch up. */
  dropped: number;
}

const SIDES: readonly Side[] = [0, 1];
const MS = OPUS_HZ / 1000;
/** A sample is drawn through so many that follow it. */
const REACH = 3;
/** One sound goes over into another within so long. */
const FADE = 5 * MS;
/** By how much faster or slower it plays at most; nobody hears that. */
const MOST_RATE = 0.005;
/** For each sample off the target: half a thousandth a millisecond. */
const RATE_PER_SAMPLE = 0.0005 / MS;
/** So far behind the target whole periods are left out, since the rate alone would take too long. */
const FAR_BEHIND = 20 * MS;
/** Between two such periods; less the farther it is behind. */
const CUT_EVERY = 100 * MS;
/** Farther behind than this it goes on from where it ought to be, at the price of a break. */
const LOST_BEHIND = 400 * MS;
/** Overdue sound is waited for, periods being repeated meanwhile; then time goes on without it. */
const MOST_WAIT = 60 * MS;
/** Of the newest judgement in the mean. */
const NEW_SHARE = 1 / 8;
/** What is concealed is as loud as what was before it for so long, then it fades. */
const LOUD = 20 * MS;
const SILENT = 80 * MS;
/** After so long without sound, what comes is played, however late it is. */
const GIVEN_UP = 400 * MS;
/** Arbitrary: leaves room for what is older than the first packet. */
const ORIGIN = OPUS_HZ;
/** Further from the newest sound than this is another sender. */
const ANEW = 2 * OPUS_HZ;

/**
 * Plays decoded packets, each as late as its link demands and no later.
 *
 * It has one clock, the device's: `frame` counts what the device has taken. `arrive` is called when
 * a packet has been decoded and `render` for each block that the device takes. Nothing is played
 * twice or out of order, other than the periods that `Played` counts. Pure.
 */
export class SoundPlayer {
  readonly counts: Played = { played: 0, concealed: 0, stretched: 0, dropped: 0 };
  readonly #ring = new Ring();
  readonly #target = new DelayTarget();
  readonly #repeated = [new Float32Array(LONGEST), new Float32Array(LONGEST)] as const;
  /** Both ears together, by which periods are found that fit both. */
  readonly #sum = (time: number) => this.#ring.at(time, 0) + this.#ring.at(time, 1);
  /** What both ears hear next. */
  readonly #pair = [0, 0] as [left: number, right: number];
  /** The RTP time of the ring's `ORIGIN`. */
  #rtpOrigin: number | null = null;
  /** What plays next, in the ring's time; null until it begins. */
  #position: number | null = null;
  /** What fades away, in the ring's time, while `#fading` samples are left of it. */
  #leaving = 0;
  #fading = 0;
  #isConcealing = false;
  #concealed = 0;
  /** Where what was concealed began, in the ring's time; nothing after it has been played. */
  #heardEnd = 0;
  #period = 1;
  #waited = 0;
  /** Where the sound ran out; null once that is judged. */
  #dry: number | null = null;
  /** Of what ran out, how much was late; the rest was lost. */
  #late = 1;
  /** How late the block is that plays. */
  #behind = 0;
  #cutAt = Number.NEGATIVE_INFINITY;
  #least: number | null = null;

  /** Plays at least so long after a packet of no delay; null for what the link demands. */
  set leastDelayMs(ms: number | null) {
    this.#least = ms === null ? null : ms * MS;
  }

  /**
   * Takes a packet that has been decoded, `rtp` being the time of its first sample: one channel for
   * both ears, or the left and the right one.
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
      // The link has become slower than anybody waits: it goes on with what comes now.
      this.#target.clear();
      this.#position = time;
    }
    this.#target.add(frame - time, frame);
  }

  /** Begins anew with what comes next: the device stood still, or another sender begins. */
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

  /** The RTP time of the next sample; null while nothing plays, or what plays is concealed. */
  get rtp(): number | null {
    if (this.#position === null || this.#rtpOrigin === null || this.#isConcealing) return null;
    return (this.#rtpOrigin + Math.round(this.#position) - ORIGIN) >>> 0;
  }

  /** How much sound is there that has not been played. */
  get aheadMs(): number {
    return this.#position === null ? 0 : Math.max(0, this.#ring.end - this.#position) / MS;
  }

  /** Fills both ears with what the device plays from `frame` on; the left alone where it has one. */
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

  /** Nothing in time has come for longer than a stall lasts. */
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
    this.#leaving = -ORIGIN; // out of silence
    this.#fading = FADE;
    return true;
  }

  /** Finds what both ears hear next, and moves on. */
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
      // Time stands still, so that what comes is played whole.
      this.#waited++;
      this.counts.stretched++;
    }
    for (const side of SIDES) this.#pair[side] = this.#invented(side);
    this.#concealed++;
  }

  /** Learns of the sound that ran out, once more has come, whether it was late or lost. */
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

  /** Leaves out what is missing, rather than make it up, where that only catches up. */
  #skip(position: number): boolean {
    const next = this.#ring.nextFrom(position + REACH);
    const missing = next - position;
    if (missing > this.#behind - FAR_BEHIND) return false;
    this.#behind -= missing;
    this.#position = next;
    return true;
  }

  /** What was missing has come: what was concealed fades into it. */
  #resume(): void {
    this.#isConcealing = false;
    this.#fading = FADE;
    this.#leaving = Number.NaN;
  }

  /** Both ears at this time, while what was before it fades away. */
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

  /** Leaves out one period, if there is enough of the sound. */
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
