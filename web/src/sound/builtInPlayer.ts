/** Starts the built-in player and notices its failures; who plays then: `soundPlayback.ts`. */

import { t } from "../words/words";
import type { FromWorker, Playing, ToWorker } from "./playerWorker";
import type { FromWorklet, ToWorklet } from "./worklet";
import workletUrl from "./worklet.ts?worker&url";

/** What the built-in player is to the page; times on the page's clock. */
export interface Heard {
  /** The sample with this RTP time is heard at `atMs`; null while nothing is, or it is concealed. */
  rtp: number | null;
  atMs: number;
  /** How much sound waits in the player. */
  delayMs: number;
  /** How long after the player it is heard. */
  outputMs: number;
  concealedMs: number;
  playedMs: number;
  stretchedMs: number;
}

export interface BuiltInPlayerEvents {
  /** Sound comes out of it. */
  plays(): void;
  /** It plays no more; the sentence says why. The browser's player has the sound already. */
  failed(why: string): void;
  /** The system has taken its device away, as for a call; and has given it back, for `play`. */
  silenced(): void;
  resumed(): void;
}

/** Of browsers that let a page choose the device (Web Audio API 1.1). */
type Routed = AudioContext & { setSinkId?: (id: string) => Promise<void> };

type TransformConstructor = new (worker: Worker) => unknown;

const SAMPLES_PER_MS = 48;
const LOOK_EVERY_MS = 50;
/** After so many looks without a word from the worklet, the device has gone. */
const MOST_SILENT_LOOKS = 4;
/** After a call it may take so much longer. */
const LOOKS_AFTER_CALL = 16;

/**
 * Firefox (153, PulseAudio) at times stops the page for ever when asked for its device's latency, by
 * `outputLatency` or `getOutputTimestamp`: the page holds the lock of the audio graph and waits for
 * the device, whose callback waits for that lock.
 */
const MUST_NOT_ASK = /Firefox\//.test(navigator.userAgent);
/** What Firefox reports there: it demands a buffer of 25 ms. */
const UNASKED_S = 0.03;

/** What this browser lacks for the built-in player, as a sentence; null if it can. */
export function lacking(scope: typeof globalThis = globalThis): string | null {
  if (!scope.isSecureContext) {
    return t("sound.needs_https");
  }
  const has =
    "RTCRtpScriptTransform" in scope && "AudioDecoder" in scope && "AudioWorkletNode" in scope;
  return has ? null : t("sound.lacks");
}

/** Whether the built-in player can play on another device than the browser's own choice. */
export function routes(scope: typeof globalThis = globalThis): boolean {
  return "setSinkId" in (scope.AudioContext?.prototype ?? {});
}

/** Has the browser keep what plays, before it is needed; resolves, whether or not that succeeds. */
export async function loadAhead(): Promise<void> {
  await fetch(workletUrl)
    .then((answer) => answer.arrayBuffer())
    .catch(() => {});
}

/**
 * Plays the sound without the browser's buffer: a worker decodes, an audio worklet plays.
 *
 * Packets reach it only after `play`; until then, and after a failure, they go to the browser's
 * own player.
 */
export class BuiltInPlayer {
  #worker: Worker | null = null;
  #context: AudioContext | null = null;
  #node: AudioWorkletNode | null = null;
  /** Between the node and the device, once it had to be softer. */
  #gain: GainNode | null = null;
  #loudness = 1;
  #output = "";
  #building: Promise<void> | null = null;
  #leastDelayMs: number | null = null;
  #newest: FromWorklet | null = null;
  #looking: ReturnType<typeof setInterval> | undefined;
  #silentLooks = 0;
  #isWanted = false;
  #isHeard = false;
  /** By the system, as for a call (Web Audio API 1.1, `interrupted`). */
  #isInterrupted = false;

  constructor(private readonly events: BuiltInPlayerEvents) {}

  /** Whether receivers can be watched. */
  get isReady(): boolean {
    return this.#worker !== null;
  }

  /** Gets ready to watch receivers; resolves to false if that is not possible. */
  start(): Promise<boolean> {
    const worker = new Worker(new URL("./playerWorker.ts", import.meta.url), { type: "module" });
    return new Promise((resolve) => {
      worker.onerror = () => resolve(false);
      worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
        if (data === "ready") {
          this.#worker = worker;
          resolve(true);
        } else {
          this.#fail(
            data === "silent"
              ? t("sound.decoder_silent")
              : t("sound.no_decoder", { error: data.failed }),
          );
        }
      };
    });
  }

  /** Watches a new peer's sound; to be called only at the moment when its receiver is created. */
  watch(receiver: RTCRtpReceiver): void {
    if (!this.#worker) return;
    const Transform = Reflect.get(globalThis, "RTCRtpScriptTransform") as TransformConstructor;
    Reflect.set(receiver, "transform", new Transform(this.#worker));
  }

  /** The payload type of packets that repeat earlier ones, as negotiated; null for none. */
  negotiated(redundancy: number | null): void {
    this.#tellWorker({ redundancy });
  }

  /** The least delay of the player's buffer, null for what the link demands. */
  set leastDelayMs(ms: number | null) {
    this.#leastDelayMs = ms;
    this.#tellWorklet({ leastDelayMs: ms });
  }

  /** As a factor of the amplitude. While that is 0 it plays all the same. */
  set loudness(loudness: number) {
    this.#loudness = loudness;
    const [context, node] = [this.#context, this.#node];
    if (!context || !node || (loudness === 1 && !this.#gain)) return;
    if (!this.#gain) {
      this.#gain = context.createGain();
      node.disconnect();
      node.connect(this.#gain).connect(context.destination);
    }
    this.#gain.gain.value = loudness;
  }

  /** Plays on the device with this id, "" for the browser's own choice; rejects if it is gone. */
  async setOutput(id: string): Promise<void> {
    this.#output = id;
    const context: Routed | null = this.#context;
    await context?.setSinkId?.(id);
  }

  /**
   * Plays from now on, as soon as there is sound; until then both get the packets. To be called
   * during a touch, without which some browsers do not let it sound.
   */
  async play(): Promise<void> {
    this.#isWanted = true;
    try {
      const context = this.#context ?? this.#open();
      if (this.#isInterrupted) {
        this.#isInterrupted = false;
        this.#watchDevice(-LOOKS_AFTER_CALL);
      }
      // Without a touch it is not resolved before there is one.
      void context.resume().catch(() => {});
      this.#building ??= this.#build(context);
      await this.#building;
      if (this.#isWanted && !this.#isHeard) this.#feed("both");
    } catch (error) {
      this.#fail(t("sound.no_device", { error: String(error) }));
    }
  }

  /** Both players get the packets, so that the browser's has sound when it takes over. */
  share(): void {
    this.#feed("both");
  }

  /** Gives the sound back to the browser's player. */
  rest(): void {
    this.#isWanted = false;
    this.#isInterrupted = false;
    this.#feed("browser");
    this.#hush();
    void this.#context?.suspend().catch(() => {});
  }

  /** What is heard now; null while this does not play. */
  heard(nowMs: number): Heard | null {
    const [context, newest] = [this.#context, this.#newest];
    if (!context || !newest || !this.#isHeard) return null;
    const { frame, rtp, aheadMs, concealed, played, stretched } = newest;
    const { contextTime = 0, performanceTime = 0 } = outputTime(context, nowMs);
    const atMs = performanceTime + (frame / SAMPLES_PER_MS - contextTime * 1000);
    return {
      rtp,
      atMs,
      delayMs: aheadMs,
      outputMs: Math.max(0, (context.currentTime - contextTime) * 1000 - (nowMs - performanceTime)),
      concealedMs: concealed / SAMPLES_PER_MS,
      playedMs: played / SAMPLES_PER_MS,
      stretchedMs: stretched / SAMPLES_PER_MS,
    };
  }

  /** How loud it plays in each ear, from 0 to 1; null while this does not play. */
  get levels(): readonly number[] | null {
    return (this.#isHeard && this.#newest?.levels) || null;
  }

  #open(): AudioContext {
    const context = new AudioContext({ latencyHint: 0, sampleRate: SAMPLES_PER_MS * 1000 });
    context.addEventListener("statechange", () => this.#stateChanged(context));
    this.#context = context;
    return context;
  }

  #stateChanged(context: AudioContext): void {
    const isInterrupted = context.state === "interrupted";
    if (context !== this.#context || !this.#isWanted || isInterrupted === this.#isInterrupted)
      return;
    this.#isInterrupted = isInterrupted;
    if (isInterrupted) {
      this.#hush();
      this.events.silenced();
    } else {
      this.#watchDevice(-LOOKS_AFTER_CALL);
      this.events.resumed();
    }
  }

  /** Nothing is heard, and the silence is no failure. */
  #hush(): void {
    clearInterval(this.#looking);
    this.#looking = undefined;
    this.#newest = null;
    this.#isHeard = false;
  }

  async #build(context: AudioContext): Promise<void> {
    if (this.#output) await (context as Routed).setSinkId?.(this.#output);
    await context.audioWorklet.addModule(workletUrl);
    const node = new AudioWorkletNode(context, "wax-player", {
      numberOfInputs: 0,
      outputChannelCount: [2],
    });
    node.port.onmessage = ({ data }: MessageEvent<FromWorklet>) => this.#told(data);
    node.onprocessorerror = () => this.#fail(t("sound.player_failed"));
    node.connect(context.destination);
    this.#node = node;
    this.loudness = this.#loudness;
    const { port1, port2 } = new MessageChannel();
    this.#tellWorklet({ sound: port1 }, [port1]);
    this.#tellWorker({ worklet: port2 }, [port2]);
    this.#tellWorklet({ leastDelayMs: this.#leastDelayMs });
  }

  #told(newest: FromWorklet): void {
    if (!this.#isWanted) return;
    this.#newest = newest;
    this.#watchDevice(0);
    if (this.#isHeard || newest.rtp === null) return;
    this.#isHeard = true;
    this.#feed("built-in");
    this.events.plays();
  }

  #watchDevice(silentLooks: number): void {
    this.#silentLooks = silentLooks;
    this.#looking ??= setInterval(() => this.#look(), LOOK_EVERY_MS);
  }

  /** A device that vanishes says nothing. Looks are counted: a blocked page hears nothing either. */
  #look(): void {
    if (++this.#silentLooks > MOST_SILENT_LOOKS) this.#fail(t("sound.device_stopped"));
  }

  #feed(playing: Playing): void {
    this.#tellWorker({ playing });
  }

  #tellWorker(message: ToWorker, transfer: Transferable[] = []): void {
    this.#worker?.postMessage(message, transfer);
  }

  #tellWorklet(message: ToWorklet, transfer: Transferable[] = []): void {
    this.#node?.port.postMessage(message, transfer);
  }

  /** The next `play` begins with another device. */
  #fail(why: string): void {
    this.rest();
    void this.#context?.close().catch(() => {});
    this.#context = null;
    this.#node = null;
    this.#gain = null;
    this.#building = null;
    this.events.failed(why);
  }
}

/** When which frame of the context is heard. */
function outputTime(context: AudioContext, nowMs: number): AudioTimestamp {
  if (!MUST_NOT_ASK) return context.getOutputTimestamp();
  return { contextTime: context.currentTime - UNASKED_S, performanceTime: nowMs };
}
