/** Plays what the worker decodes, on the audio thread (W3C, Web Audio: AudioWorklet). */

import { LevelMeter } from "./loudness";
import { OPUS_HZ } from "./opus";
import type { Decoded } from "./playerWorker";
import { type Played, SoundPlayer } from "./soundPlayer";

/** Messages from the page: the port that brings the sound, and its minimum delay. */
export type ToWorklet = { sound: MessagePort } | { leastDelayMs: number | null };
/** Messages to the page: at `frame` of the context the sample with this RTP time is next. */
export interface FromWorklet extends Played {
  frame: number;
  rtp: number | null;
  aheadMs: number;
  /** The levels since the last message, from 0 to 1, left first. */
  levels: number[];
}

declare const currentFrame: number;
declare class AudioWorkletProcessor {
  readonly port: MessagePort;
}
declare function registerProcessor(name: string, of: new () => AudioWorkletProcessor): void;

/** About every 50 ms. */
const TELL_EVERY_BLOCKS = 19;
/** If the device's clock falls this far behind wall time, it has stalled. */
const STOOD_MS = 100;

class Player extends AudioWorkletProcessor {
  readonly #player = new SoundPlayer();
  readonly #meter = new LevelMeter();
  #blocks = 0;
  /** The smallest offset of wall time from the device's clock. */
  #apartMs = Number.POSITIVE_INFINITY;

  constructor() {
    super();
    this.port.onmessage = ({ data }: MessageEvent<ToWorklet>) => {
      if ("sound" in data) this.#listen(data.sound);
      else this.#player.leastDelayMs = data.leastDelayMs;
    };
  }

  #listen(sound: MessagePort): void {
    sound.onmessage = ({ data }: MessageEvent<Decoded>) => {
      if (data) this.#player.arrive(data.rtp, data.channels, currentFrame);
      else this.#player.restart();
    };
  }

  process(_: Float32Array[][], outputs: Float32Array[][]): boolean {
    this.#noticePause();
    const out = outputs[0] ?? [];
    const [left] = out;
    if (!left) return true;
    this.#player.render(out, currentFrame);
    this.#meter.add(out);
    if (++this.#blocks % TELL_EVERY_BLOCKS === 0) this.#tell(currentFrame + left.length);
    return true;
  }

  #noticePause(): void {
    const apartMs = Date.now() - (currentFrame * 1000) / OPUS_HZ;
    if (apartMs > this.#apartMs + STOOD_MS) {
      this.#player.restart();
      this.#apartMs = apartMs;
    }
    this.#apartMs = Math.min(this.#apartMs + 0.001, apartMs);
  }

  #tell(frame: number): void {
    const { rtp, aheadMs, counts } = this.#player;
    const levels = this.#meter.flush();
    this.port.postMessage({ frame, rtp, aheadMs, levels, ...counts } satisfies FromWorklet);
  }
}

registerProcessor("wax-player", Player);
