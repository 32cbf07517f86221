/** What is reported to the server, and how often; ages: `picture.ts`, `sound.ts`. */

import type { Report, RtpClock } from "../messages";
import type { ServerClock } from "../serverClock";
import type { Heard } from "../sound/builtInPlayer";
import type { Facts } from "../state";
import { Arrivals } from "./arrivals";
import { PictureCounts, SoundCounts } from "./counts";
import { PictureMeter } from "./picture";
import { RtpTimeline } from "./rtp";
import { SoundMeter } from "./sound";
import { type InboundStats, readStats } from "./stats";

const REPORT_EVERY_MS = 250;
/** Often enough for a median in each report, at hardly any cost. */
const SAMPLES_PER_REPORT = 5;
/** Every 100 ms: whether the sound's age has moved, so that the picture must follow. */
const SAMPLES_PER_LOOK = 2;
/** The noise of single measurements is below this. */
const MOVED_MS = 15;
/** People cannot read figures that change faster than this. */
const REPORTS_PER_FACTS = 4;
/** After a stream has started, this many reports are all sent, until the figures have settled. */
const UNSETTLED_REPORTS = 40;

/** The connection to measure, and where reports go; `peer` is null while there is none. */
export interface Measured {
  readonly peer: Receivers | null;
  readonly clock: Pick<ServerClock, "toServerMs" | "errorMs" | "rttMs">;
  readonly isThin: boolean;
  readonly mayDrive: boolean;
  sendDrive(report: Report): void;
}

/** The receivers of the two streams, null where there is none. */
export interface Receivers {
  readonly sound: RTCRtpReceiver | null;
  readonly picture: RTCRtpReceiver | null;
}

export interface ReporterOptions {
  link: Measured;
  /** Which streams are on; one that is off is not measured. */
  wants: () => { sound: boolean; picture: boolean };
  /** What the built-in player plays; null while the browser's plays. */
  heard: (nowMs: number) => Heard | null;
  onFacts: (facts: Facts) => void;
}

/** Measures both streams while there is a peer, reports to the server, and updates the figures. */
export class Reporter {
  readonly picture: PictureMeter;
  /** The screen's refresh interval, null while unknown. */
  refreshMs: number | null = null;
  readonly #timelines = { audio: new RtpTimeline(), video: new RtpTimeline() };
  readonly #sound: SoundMeter;
  #counts = { sound: new SoundCounts(), picture: new PictureCounts() };
  #arrivals = new Arrivals();
  #ticks = 0;
  #reports = 0;
  #reported = "";
  /** The sound's age in the last report that was sent. */
  #toldMs: number | null = null;

  constructor(private readonly options: ReporterOptions) {
    const toServerMs = (pageMs: number) => options.link.clock.toServerMs(pageMs);
    const { audio, video } = this.#timelines;
    this.picture = new PictureMeter(video, toServerMs);
    this.#sound = new SoundMeter(audio, toServerMs, performance.timeOrigin);
    setInterval(() => this.#tick(), REPORT_EVERY_MS / SAMPLES_PER_REPORT);
  }

  /** Forgets earlier measurements, for a new peer. */
  reset(): void {
    this.#timelines.audio.set(null);
    this.#timelines.video.set(null);
    this.#counts = { sound: new SoundCounts(), picture: new PictureCounts() };
    this.#arrivals = new Arrivals();
    this.picture.reset();
    this.#sound.flush();
    this.#reports = 0;
  }

  mapped(message: RtpClock): void {
    this.#timelines[message.kind].set(message);
  }

  #tick(): void {
    const { peer } = this.options.link;
    if (!peer) return;
    const heardMs = this.options.wants().sound ? this.#listen(peer, performance.now()) : null;
    const isDue = ++this.#ticks % SAMPLES_PER_REPORT === 0;
    const isLook = this.#ticks % SAMPLES_PER_LOOK === 0;
    if (isDue || (isLook && this.#hasMoved(heardMs))) void this.#report(peer, isDue);
  }

  /** Returns the age of what the built-in player plays; null while the browser's plays. */
  #listen(peer: Receivers, nowMs: number): number | null {
    const heard = this.options.heard(nowMs);
    if (heard) return heard.rtp === null ? null : this.#sound.heard(heard.rtp, heard.atMs);
    this.#sound.sample(peer.sound?.getSynchronizationSources()[0], nowMs);
    return null;
  }

  #hasMoved(heardMs: number | null): boolean {
    if (heardMs === null || this.#toldMs === null || this.options.link.isThin) return false;
    return Math.abs(heardMs - this.#toldMs) > MOVED_MS;
  }

  async #report(peer: Receivers, isDue: boolean): Promise<void> {
    const { link, wants, onFacts } = this.options;
    const { sound, picture } = wants();
    const reported = `${sound} ${picture}`;
    if (reported !== this.#reported) this.#reports = 0;
    this.#reported = reported;
    const [ofSound, ofPicture] = await Promise.all([
      sound && peer.sound ? readStats(peer.sound) : null,
      picture && peer.picture ? readStats(peer.picture) : null,
    ]);
    if (peer !== link.peer) return;
    const nowMs = performance.now();
    const counts = this.#counts;
    // A hidden page presents no frames, so their age says nothing about the link.
    const isSeen = picture && !document.hidden;
    if (!isSeen) this.picture.freezes.rest();
    if (!ofSound) counts.sound.rest();
    if (!ofPicture) counts.picture.rest();
    const seen = this.picture.flush(nowMs);
    const heardMs = this.#sound.flush();
    const heard = sound ? this.options.heard(nowMs) : null;
    const played = heard
      ? counts.sound.builtIn(heard, nowMs)
      : ofSound && counts.sound.next(ofSound, nowMs);
    const report: Report = {
      type: "report",
      sound: played && {
        // After the receiver the audio device adds its own delay; the built-in player knows.
        age_ms: heardMs === null ? null : heardMs + (heard ? 0 : (played.output_ms ?? 0)),
        ...played,
        player: heard ? "built-in" : "browser",
      },
      picture: ofPicture && {
        age_ms: isSeen ? seen.ageMs : null,
        rate_hz: isSeen ? seen.rateHz : null,
        ...counts.picture.next(ofPicture, this.picture.freezes, nowMs),
      },
      clock_error_ms: link.clock.errorMs(nowMs),
    };
    const isFact = isDue && this.#reports++ % REPORTS_PER_FACTS === 0;
    // Observers, who may be many, and pages on a slow link send one report a second.
    const isEager = !isDue || link.mayDrive || this.#reports <= UNSETTLED_REPORTS;
    if (isFact || (isEager && !link.isThin)) {
      link.sendDrive(report);
      this.#toldMs = heard && heardMs;
    }
    if (isFact) onFacts(this.#facts(report, ofSound?.inbound, ofPicture?.inbound, nowMs));
  }

  #facts(
    { sound, picture, clock_error_ms }: Report,
    ofSound: InboundStats | undefined,
    ofPicture: InboundStats | undefined,
    nowMs: number,
  ): Facts {
    const pictureMs = picture?.age_ms ?? null;
    const soundMs = sound?.age_ms ?? null;
    const arrived = ofPicture?.framesReceived ?? ofPicture?.framesDecoded;
    return {
      pictureMs,
      pictureErrorMs: this.#pictureErrorMs(clock_error_ms),
      soundMs,
      skewMs: soundMs === null || pictureMs === null ? null : soundMs - pictureMs,
      roundTripMs: this.options.link.clock.rttMs,
      jitterMs: ofSound?.jitter === undefined ? null : ofSound.jitter * 1000,
      bufferMs: sound?.delay_ms ?? null,
      arrivedFps: this.#arrivals.next(arrived, nowMs),
      fps: picture?.rate_hz ?? null,
      pauses: sound && this.#counts.sound.pauses.summarize(nowMs),
      freezes: picture && this.#counts.picture.freezes.summarize(nowMs),
    };
  }

  /**
   * The possible error of the picture's age: that of the clocks plus half the screen's refresh
   * interval. RTP time at 90 kHz adds nothing significant.
   */
  #pictureErrorMs(clockErrorMs: number | null): number | null {
    if (clockErrorMs === null || this.refreshMs === null) return null;
    return clockErrorMs + this.refreshMs / 2;
  }
}
