import type { Link } from "../link/link";
import type { Peer } from "../link/peer";
import type { Report, RtpClock } from "../messages";
import type { Facts } from "../state";
import { bufferCounters, DelayMeter } from "./delay";
import { PictureMeter } from "./picture";
import { RtpTimeline } from "./rtp";
import { SoundMeter } from "./sound";

const REPORT_EVERY_MS = 250;
/** Often enough for a median of each report, seldom enough to cost nothing. */
const SAMPLES_PER_REPORT = 5;
/** Figures that change faster than this cannot be read. */
const REPORTS_PER_FACTS = 4;
/** So many reports are all sent after a stream has begun, until both have settled. */
const UNSETTLED_REPORTS = 40;

export interface ReporterOptions {
  link: Link;
  /** What is on; a stream that is off is not measured. */
  wants: () => { sound: boolean; picture: boolean };
  onFacts: (facts: Facts) => void;
}

/** Measures both streams while there is a peer, tells the server, and now and then a person. */
export class Reporter {
  readonly picture: PictureMeter;
  readonly #timelines = { audio: new RtpTimeline(), video: new RtpTimeline() };
  readonly #sound: SoundMeter;
  #delays = { sound: new DelayMeter(), picture: new DelayMeter() };
  #ticks = 0;
  #reports = 0;
  #reported = "";

  constructor(private readonly options: ReporterOptions) {
    const toServerMs = (pageMs: number) => options.link.clock.toServerMs(pageMs);
    const { audio, video } = this.#timelines;
    this.picture = new PictureMeter(video, toServerMs);
    this.#sound = new SoundMeter(audio, toServerMs, performance.timeOrigin);
    setInterval(() => this.#tick(), REPORT_EVERY_MS / SAMPLES_PER_REPORT);
  }

  /** A fresh peer: nothing that was measured before holds. */
  reset(): void {
    this.#timelines.audio.set(null);
    this.#timelines.video.set(null);
    this.#delays = { sound: new DelayMeter(), picture: new DelayMeter() };
    this.picture.reset();
    this.#sound.take();
    this.#reports = 0;
  }

  mapped(message: RtpClock): void {
    this.#timelines[message.kind].set(message);
  }

  #tick(): void {
    const { peer } = this.options.link;
    if (!peer) return;
    if (this.options.wants().sound) {
      this.#sound.sample(peer.sound.getSynchronizationSources()[0], performance.now());
    }
    if (++this.#ticks % SAMPLES_PER_REPORT === 0) void this.#report(peer);
  }

  async #report(peer: Peer): Promise<void> {
    const { link, wants, onFacts } = this.options;
    const { sound, picture } = wants();
    const reported = `${sound} ${picture}`;
    if (reported !== this.#reported) this.#reports = 0;
    this.#reported = reported;
    const [soundMs, pictureMs] = await Promise.all([
      sound ? this.#delayMs(peer.sound, this.#delays.sound) : null,
      picture ? this.#delayMs(peer.picture, this.#delays.picture) : null,
    ]);
    if (peer !== link.peer) return;
    const nowMs = performance.now();
    const seen = this.picture.take(nowMs);
    const report: Report = {
      type: "report",
      sound: sound ? { age_ms: this.#sound.take(), delay_ms: soundMs, rate_hz: null } : null,
      picture: picture ? { age_ms: seen.ageMs, delay_ms: pictureMs, rate_hz: seen.rateHz } : null,
      clock_error_ms: link.clock.errorMs(nowMs),
    };
    const isFact = this.#reports++ % REPORTS_PER_FACTS === 0;
    // Those who only watch are many; once settled, a report a second of theirs is enough.
    if (isFact || link.mayDrive || this.#reports <= UNSETTLED_REPORTS) link.sendDrive(report);
    if (!isFact) return;
    onFacts({
      pictureMs: report.picture?.age_ms ?? null,
      soundMs: report.sound?.age_ms ?? null,
      roundTripMs: link.clock.rttMs,
      fps: report.picture?.rate_hz ?? null,
    });
  }

  async #delayMs(receiver: RTCRtpReceiver, meter: DelayMeter): Promise<number | null> {
    return meter.next(await bufferCounters(receiver));
  }
}
