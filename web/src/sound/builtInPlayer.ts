/** Starts the built-in player and detects its failures; who plays then: `soundPlayback.ts`. */

import { Unsettled, within } from "../within";
import { t } from "../words/words";
import type { FromWorker, Playing, ToWorker } from "./playerWorker";
import type { FromWorklet, ToWorklet } from "./worklet";
import workletUrl from "./worklet.ts?worker&url";

/** What the built-in player plays; times on the page's clock. */
export interface Heard {
  /** The sample with this RTP time is heard at `atMs`; null while silent or concealing. */
  rtp: number | null;
  atMs: number;
  /** How much sound is buffered in the player. */
  delayMs: number;
  /** The delay of the output device. */
  outputMs: number;
  concealedMs: number;
  playedMs: number;
  stretchedMs: number;
}

export interface BuiltInPlayerEvents {
  /** Sound has started to play. */
  plays(): void;
  /** The player has failed, and why; the browser's player gets the packets already. */
  failed(why: string): void;
  /** The system has taken the device away, as for a phone call, or (`resumed`) given it back. */
  silenced(): void;
  resumed(): void;
}

/** An `AudioContext` whose device the page can choose (Web Audio API 1.1). */
type Routed = AudioContext & { setSinkId?: (id: string) => Promise<void> };

type TransformConstructor = new (worker: Worker) => unknown;

const SAMPLES_PER_MS = 48;
const LOOK_EVERY_MS = 50;
/** After this many checks without a message from the worklet, the device is gone. */
const MOST_SILENT_LOOKS = 4;
/** How many more checks the device gets after a phone call. */
const LOOKS_AFTER_CALL = 16;

/**
 * Firefox (153, PulseAudio) sometimes deadlocks when asked for its device's latency, by
 * `outputLatency` or `getOutputTimestamp`: the page holds the lock of the audio graph and waits for
 * the device, whose callback waits for that lock.
 */
const MUST_NOT_ASK = /Firefox\//.test(navigator.userAgent);
/** What Firefox reports there, as it requests a buffer of 25 ms. */
const UNASKED_S = 0.03;

/** What this browser lacks for the built-in player, as a sentence; null for nothing. */
export function lacking(scope: typeof globalThis = globalThis): string | null {
  if (!scope.isSecureContext) {
    return t("sound.needs_https");
  }
  const has =
    "RTCRtpScriptTransform" in scope && "AudioDecoder" in scope && "AudioWorkletNode" in scope;
  return has ? null : t("sound.lacks");
}

/** Whether the built-in player can play on a device other than the browser's default. */
export function routes(scope: typeof globalThis = globalThis): boolean {
  return "setSinkId" in (scope.AudioContext?.prototype ?? {});
}

/** Loads the player's code into the browser's cache; resolves even if that fails. */
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
  /** Between the node and the device, once the volume was lowered. */
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
  /** Whether the system has interrupted it (Web Audio API 1.1, `interrupted`), as for a call. */
  #isInterrupted = false;

  constructor(private readonly events: BuiltInPlayerEvents) {}

  /** Whether receivers can be watched. */
  get isReady(): boolean {
    return this.#worker !== null;
  }

  /** Starts the worker that watches receivers; resolves to false if that fails. */
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

  /** Watches a new peer's sound; call it only when its receiver has just been created. */
  watch(receiver: RTCRtpReceiver): void {
    if (!this.#worker) return;
    const Transform = Reflect.get(globalThis, "RTCRtpScriptTransform") as TransformConstructor;
    Reflect.set(receiver, "transform", new Transform(this.#worker));
  }

  /** Sets the negotiated payload type of redundant packets; null for none. */
  negotiated(redundancy: number | null): void {
    this.#tellWorker({ redundancy });
  }

  /** The minimum delay of the player's buffer; null for what the link demands. */
  set leastDelayMs(ms: number | null) {
    this.#leastDelayMs = ms;
    this.#tellWorklet({ leastDelayMs: ms });
  }

  /** A factor of the amplitude; at 0 the player keeps playing. */
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

  /** Plays on the device with this id, "" for the browser's default; rejects if it is gone. */
  async setOutput(id: string): Promise<void> {
    this.#output = id;
    if (this.#context) await this.#route(this.#context);
  }

  async #route(context: Routed): Promise<void> {
    const routing = context.setSinkId?.(this.#output);
    if (routing) await within("AudioContext.setSinkId", routing);
  }

  /**
   * Plays as soon as there is sound; until then both players get the packets. Call it during a
   * touch, without which some browsers stay silent.
   */
  async play(): Promise<void> {
    this.#isWanted = true;
    try {
      const context = this.#context ?? this.#open();
      if (this.#isInterrupted) {
        this.#isInterrupted = false;
        this.#watchDevice(-LOOKS_AFTER_CALL);
      }
      this.#resume(context);
      this.#building ??= this.#build(context);
      await this.#building;
      if (this.#isWanted && !this.#isHeard) this.#feed("both");
    } catch (error) {
      this.#closed(error);
    }
  }

  /** The device cannot be opened, or the browser never says whether it can. */
  #closed(error: unknown): void {
    const isHung = error instanceof Unsettled;
    this.#fail(isHung ? error.message : t("sound.no_device", { error: String(error) }));
  }

  /** Feeds both players, so that the browser's has sound when it takes over. */
  share(): void {
    this.#feed("both");
  }

  /** Stops, and feeds only the browser's player. */
  rest(): void {
    this.#isWanted = false;
    this.#isInterrupted = false;
    this.#feed("browser");
    this.#hush();
    void this.#context?.suspend().catch(() => {});
  }

  /** What is heard now; null while this player does not play. */
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

  /** The level in each ear, from 0 to 1; null while this player does not play. */
  get levels(): readonly number[] | null {
    return (this.#isHeard && this.#newest?.levels) || null;
  }

  /** Without a touch, the browser's promise stays pending until there is one. */
  #resume(context: AudioContext): void {
    within("AudioContext.resume", context.resume()).catch((error) => {
      const isStuck = error instanceof Unsettled && context.state === "suspended";
      if (
        isStuck &&
        context === this.#context &&
        this.#isWanted &&
        navigator.userActivation.hasBeenActive
      )
        this.#closed(error);
    });
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

  /** Expects silence, so that it does not count as a failure. */
  #hush(): void {
    clearInterval(this.#looking);
    this.#looking = undefined;
    this.#newest = null;
    this.#isHeard = false;
  }

  async #build(context: AudioContext): Promise<void> {
    if (this.#output) await this.#route(context);
    await within("AudioWorklet.addModule", context.audioWorklet.addModule(workletUrl));
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

  /** A device vanishes without an event. Counts checks: a blocked page gets no messages either. */
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

  /** Reports a failure; the next `play` opens a new context. */
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

/** Which time of the context is heard when. */
function outputTime(context: AudioContext, nowMs: number): AudioTimestamp {
  if (!MUST_NOT_ASK) return context.getOutputTimestamp();
  return { contextTime: context.currentTime - UNASKED_S, performanceTime: nowMs };
}
