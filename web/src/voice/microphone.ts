import { levelOfPower } from "../sound/loudness";
import { type Code, t } from "../words/words";

/** Why there is no microphone, in a sentence that says what to do. */
export class MicrophoneError extends Error {}

/** What the user can do about each error of `getUserMedia`. */
const SENTENCES: Record<string, Code> = {
  NotAllowedError: "voice.not_allowed",
  NotFoundError: "voice.not_found",
  NotReadableError: "voice.in_use",
  AbortError: "voice.no_start",
};

/** The samples for one level: less than a tenth of a second at 48 kHz. */
const WINDOW = 2048;

/** Why this page cannot have a microphone at all, as a sentence; null if it can ask for one. */
export function hindrance(scope: typeof globalThis = globalThis): string | null {
  if (!scope.isSecureContext) return t("voice.insecure");
  return scope.navigator?.mediaDevices ? null : t("voice.none");
}

/** An open microphone, with the browser's own echo cancellation. */
export class Microphone {
  readonly track: MediaStreamTrack;
  readonly #context: AudioContext | null;
  readonly #analyser: AnalyserNode | null;
  readonly #samples = new Float32Array(WINDOW);

  /** Opens the microphone, which the browser may ask about. Rejects with a `MicrophoneError`. */
  static async open(onGone: (sentence: string) => void): Promise<Microphone> {
    const problem = hindrance();
    if (problem !== null) throw new MicrophoneError(problem);
    try {
      const stream = await navigator.mediaDevices.getUserMedia({
        audio: {
          echoCancellation: true,
          noiseSuppression: true,
          autoGainControl: true,
          channelCount: 1,
        },
      });
      return new Microphone(stream, onGone);
    } catch (error) {
      const name = error instanceof Error ? error.name : "";
      const code = SENTENCES[name] ?? "voice.cannot_open";
      throw new MicrophoneError(t(code, { error: String(error) }));
    }
  }

  private constructor(stream: MediaStream, onGone: (sentence: string) => void) {
    const [track] = stream.getAudioTracks();
    if (!track) throw new DOMException("no track", "NotFoundError");
    this.track = track;
    track.addEventListener("ended", () => onGone(t("voice.gone")), { once: true });
    let context: AudioContext | null = null;
    let analyser: AnalyserNode | null = null;
    try {
      context = new AudioContext();
      analyser = new AnalyserNode(context, { fftSize: WINDOW });
      context.createMediaStreamSource(stream).connect(analyser);
    } catch {
      // Without Web Audio there is no level, but the voice is still sent.
    }
    this.#context = context;
    this.#analyser = analyser;
  }

  /** The level now, from 0 to 1, linear in dB. */
  get level(): number {
    if (!this.#analyser) return 0;
    this.#analyser.getFloatTimeDomainData(this.#samples);
    return levelOf(this.#samples);
  }

  close(): void {
    this.track.stop();
    void this.#context?.close().catch(() => {});
  }
}

/** The level of samples (full scale 1): 0 at −60 dB, 1 at 0 dB. Pure. */
export function levelOf(samples: Float32Array): number {
  let sum = 0;
  for (const sample of samples) sum += sample * sample;
  return levelOfPower(sum / Math.max(1, samples.length));
}
