/**
 * Takes a receiver's encoded sound (W3C, WebRTC Encoded Transform): decodes it (W3C, WebCodecs) for
 * the built-in player, passes it to the browser's, or both while they change over.
 */

import { OPUS_HZ } from "./opus";
import { type Block, splitRed } from "./red";
import { Sequence } from "./sequence";

/** Who gets the packets. */
export type Playing = "browser" | "built-in" | "both";

/** Messages from the page; `worklet` receives the decoded sound. */
export type ToWorker =
  | { playing: Playing }
  | { redundancy: number | null }
  | { worklet: MessagePort };
/** Messages to the page. */
export type FromWorker = "ready" | "silent" | { failed: string };
/** Messages to the worklet, the left ear first; null when another sender begins. */
export type Decoded = { rtp: number; channels: Float32Array[] } | null;

interface EncodedFrame {
  data: ArrayBuffer;
  timestamp?: number;
  getMetadata(): { rtpTimestamp?: number; payloadType?: number };
}

interface Transformer {
  readable: ReadableStream<EncodedFrame>;
  writable: WritableStream<EncodedFrame>;
}

/** A decoder that returns nothing for this long, although it has input, does not work. */
const ANSWERS_WITHIN_MS = 500;

let playing: Playing = "browser";
/** The payload type of packets that repeat earlier ones (RFC 2198). */
let redundancy: number | null = null;
let worklet: MessagePort | null = null;
/** The newest peer that has sent something; only its sound is played. */
let current: Decoding | null = null;

function failed(why: FromWorker): void {
  // The browser plays from the next packet on.
  playing = "browser";
  postMessage(why);
}

/** The browser's own text of an error. */
function saidOf(error: unknown): FromWorker {
  return { failed: error instanceof Error ? error.message : String(error) };
}

/** Decodes one receiver's sound. */
class Decoding {
  readonly #sequence = new Sequence();
  /** RTP times that the decoder has not returned yet; it returns one sound per packet, in order. */
  readonly #pending: number[] = [];
  #answeredMs = 0;
  #decoder: AudioDecoder | null = null;
  #waking: ReturnType<typeof setTimeout> | undefined;

  #isKnown = false;

  add(blocks: Block[]): void {
    if (!this.#isKnown) {
      this.#isKnown = true;
      current = this;
      worklet?.postMessage(null satisfies Decoded);
    } else if (current !== this) {
      return;
    }
    this.#decode(this.#sequence.add(blocks, performance.now()));
    this.#wake();
  }

  close(): void {
    clearTimeout(this.#waking);
    if (this.#decoder && this.#decoder.state !== "closed") this.#decoder.close();
    this.#decoder = null;
  }

  #wake(): void {
    clearTimeout(this.#waking);
    const { nextDueMs } = this.#sequence;
    if (nextDueMs === null) return;
    this.#waking = setTimeout(() => {
      this.#decode(this.#sequence.due(performance.now()));
      this.#wake();
    }, nextDueMs - performance.now());
  }

  #decode(blocks: Block[]): void {
    try {
      for (const { rtp, data } of blocks) {
        this.#decoder ??= this.#open();
        // After an outage many packets come at once: the decoder's silence counts, not the backlog.
        if (this.#pending.length === 0) this.#answeredMs = performance.now();
        this.#pending.push(rtp);
        if (performance.now() - this.#answeredMs > ANSWERS_WITHIN_MS) {
          this.#fail("silent");
          return;
        }
        this.#decoder.decode(new EncodedAudioChunk({ type: "key", timestamp: 0, data }));
      }
    } catch (error) {
      this.#fail(saidOf(error));
    }
  }

  #open(): AudioDecoder {
    const decoder = new AudioDecoder({
      output: (sound) => this.#decoded(sound),
      error: (error) => this.#fail(saidOf(error)),
    });
    // Each packet has one channel or two; a stereo decoder handles both (RFC 6716, 4.5.1).
    decoder.configure({ codec: "opus", sampleRate: OPUS_HZ, numberOfChannels: 2 });
    return decoder;
  }

  #decoded(sound: AudioData): void {
    const rtp = this.#pending.shift();
    this.#answeredMs = performance.now();
    const channels = Array.from({ length: sound.numberOfChannels }, (_, planeIndex) => {
      const samples = new Float32Array(sound.numberOfFrames);
      sound.copyTo(samples, { planeIndex, format: "f32-planar" });
      return samples;
    });
    sound.close();
    if (rtp === undefined || current !== this) return;
    const buffers = channels.map((one) => one.buffer);
    worklet?.postMessage({ rtp, channels } satisfies Decoded, buffers);
  }

  #fail(why: FromWorker): void {
    if (this.#decoder && this.#decoder.state !== "closed") this.#decoder.close();
    this.#decoder = null;
    this.#pending.length = 0;
    failed(why);
  }
}

addEventListener("message", ({ data }: MessageEvent<ToWorker>) => {
  if ("playing" in data) playing = data.playing;
  else if ("redundancy" in data) redundancy = data.redundancy;
  else worklet = data.worklet;
});

addEventListener("rtctransform", (event) => {
  const { transformer } = event as Event & { transformer: Transformer };
  const { readable, writable } = transformer;
  const decoding = new Decoding();
  const deciding = new TransformStream<EncodedFrame, EncodedFrame>({
    transform(frame, controller) {
      if (playing !== "browser") {
        const { rtpTimestamp, payloadType } = frame.getMetadata();
        const rtp = rtpTimestamp ?? frame.timestamp;
        // A copy: the frame is transferred below, and a packet may have to wait for an earlier one.
        const data = new Uint8Array(frame.data.slice(0));
        if (rtp !== undefined) {
          const repeats = payloadType !== undefined && payloadType === redundancy;
          decoding.add(repeats ? splitRed(data, rtp) : [{ rtp, data }]);
        }
      }
      if (playing !== "built-in") controller.enqueue(frame);
    },
  });
  void readable
    .pipeThrough(deciding)
    .pipeTo(writable)
    // The stream ends when the page closes the connection, which is no error.
    .catch(() => {})
    .finally(() => decoding.close());
});

// A transform created before this message would never get its streams.
postMessage("ready" satisfies FromWorker);
