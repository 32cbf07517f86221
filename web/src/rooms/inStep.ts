import { applyPlayout } from "../jitterBufferTargets";
import { type Receivers, Reporter } from "../measure/report";
import type { Playout, Report } from "../messages";
import type { ServerClock } from "../serverClock";
import type { Facts } from "../state";
import { CaptureClock, rtpClock, type Source } from "./captures";
import { HoldBack } from "./holdBack";
import type { RenditionChoice } from "./rendition";

export interface InStepOptions {
  wants: () => { sound: boolean; picture: boolean };
  /** Whether the picture is shown without waiting for its sound. */
  isPictureFirst: () => boolean;
  rendition: RenditionChoice;
  /** The clock of the capture times, as far as it is known. */
  wall: Pick<ServerClock, "toServerMs" | "errorMs">;
  onFacts: (facts: Facts) => void;
  onPlayout: (playout: Playout) => void;
}

const REPORTS_PER_ARRIVING = 4;

/** The server's codes for why the picture is held back. */
const REASONS = {
  first: "sync.neither",
  none: "sync.nothing",
  held: "sync.follows",
} as const;

/**
 * Measures a LiveKit room's streams and plays them in step, as the robot's server controls it for
 * its own viewers: here only the page knows what arrives. The fastest sample counts as age 0; only
 * the ages that are shown use the server's clock, whose error is larger than the skew.
 */
export class InStep {
  readonly #reporter: Reporter;
  readonly #clock = new CaptureClock();
  readonly #hold = new HoldBack();
  #receivers: Receivers | null = null;
  #reports = 0;
  #frozenMs: number | null = null;

  constructor(private readonly options: InStepOptions) {
    const peer = () => this.#receivers;
    this.#reporter = new Reporter({
      link: {
        get peer() {
          return peer();
        },
        clock: this.#clock,
        isThin: false,
        // Reports stay in the page, so they can be frequent.
        mayDrive: true,
        sendDrive: (report) => this.#reported(report, performance.now()),
      },
      wants: options.wants,
      heard: () => null,
      onFacts: (facts) => options.onFacts(this.#aged(facts, performance.now())),
    });
  }

  get picture(): RTCRtpReceiver | undefined {
    return this.#receivers?.picture ?? undefined;
  }

  /** Sets the receivers that play; null for none. */
  setReceivers(receivers: Receivers | null): void {
    const isNew = receivers?.picture !== this.#receivers?.picture;
    this.#receivers = receivers;
    this.#reporter.reset();
    this.#frozenMs = null;
    if (isNew) this.#hold.restart(performance.now());
    if (receivers) this.#apply();
  }

  /** Records that the frame with this RTP time is presented at `atMs`. */
  presented(rtp: number | undefined, atMs: number): void {
    this.#reporter.picture.presented(rtp, atMs);
  }

  /** Reads the capture times; call it several times a second. */
  readCaptures(nowMs: number): void {
    const { sound, picture } = this.#receivers ?? {};
    for (const [kind, receiver] of [["audio", sound] as const, ["video", picture] as const]) {
      const source: Source | undefined = receiver?.getSynchronizationSources()[0];
      const clock = rtpClock(kind, source);
      if (!clock) continue;
      this.#clock.add(clock.origin_server_ms, nowMs);
      this.#reporter.mapped(clock);
    }
  }

  #reported({ sound, picture }: Report, nowMs: number): void {
    const ages = difference(sound?.age_ms, picture?.age_ms);
    const earlyMs = ages ?? difference(sound?.delay_ms, picture?.delay_ms);
    const heldMs = this.#hold.heldMs;
    if (this.options.isPictureFirst() || !sound) this.#hold.forget();
    else if (earlyMs !== null) this.#hold.add(earlyMs, nowMs);
    if (this.#hold.heldMs !== heldMs) this.#apply();
    if (picture && ++this.#reports % REPORTS_PER_ARRIVING === 0) {
      const frozenMs = picture.frozen_ms ?? 0;
      this.options.rendition.add(
        {
          delayMs: difference(picture.age_ms, picture.delay_ms),
          frozenMs: this.#frozenMs === null ? 0 : frozenMs - this.#frozenMs,
        },
        nowMs,
      );
      this.#frozenMs = frozenMs;
    }
  }

  /** The facts with ages by the server's clock; without ages where it is not known. */
  #aged(facts: Facts, nowMs: number): Facts {
    const { wall } = this.options;
    const fastestMs = difference(wall.toServerMs(nowMs), this.#clock.toServerMs(nowMs));
    return {
      ...facts,
      pictureMs: sum(facts.pictureMs, fastestMs),
      pictureErrorMs: wall.errorMs(nowMs),
      soundMs: sum(facts.soundMs, fastestMs),
    };
  }

  #apply(): void {
    const isFirst = this.options.isPictureFirst();
    const { heldMs } = this.#hold;
    const playout: Playout = {
      type: "playout",
      policy: isFirst ? "video-first" : "audio-master",
      player: "browser",
      sound_target_ms: null,
      picture_target_ms: heldMs,
      reason: { code: isFirst ? REASONS.first : heldMs === 0 ? REASONS.none : REASONS.held },
    };
    applyPlayout(playout, this.#receivers?.sound ?? null, this.#receivers?.picture ?? null);
    this.options.onPlayout(playout);
  }
}

function sum(a: number | null, b: number | null): number | null {
  return a !== null && b !== null ? a + b : null;
}

function difference(a: number | null | undefined, b: number | null | undefined): number | null {
  return typeof a === "number" && typeof b === "number" ? a - b : null;
}
