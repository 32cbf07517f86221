import { SET_POINT_BITS, WAITING_BYTES } from "../drive/sendRate";

/** How a voice is encoded. */
export interface VoiceEncoding {
  bitrateBps: number;
  /** The sound in one packet. */
  packetMs: 20 | 40 | 60;
}

/** What is known about the uplink. */
export interface Uplink {
  /** The server's estimate of the link to this page; null before the first. */
  linkBps: number | null;
  /** The bytes of commands queued in the browser. */
  waitingBytes: number;
  roundTripMs: number | null;
  /** The set-points that this page sends a second; 0 if it does not drive. */
  commandHz: number;
}

/** The best first. The last is still intelligible; one of its packets takes 25 ms at 33 kbit/s. */
export const ENCODINGS: readonly VoiceEncoding[] = [
  { bitrateBps: 24_000, packetMs: 20 },
  { bitrateBps: 12_000, packetMs: 40 },
  { bitrateBps: 6000, packetMs: 60 },
];

/** A packet's headers: RTP with its extensions, SRTP's tag, UDP and IP. */
const HEADER_BITS = 58 * 8;
/** The headroom, so that a command rarely waits for a packet of the voice. */
const MARGIN = 1.5;
/**
 * Only the downlink is measured. A modem's uplink is 60 % of it; a faster link's may be a tenth,
 * but hardly less than this.
 */
const MODEM_SHARE = 0.6;
const LEAST_SHARE = 0.1;
const COMMON_BPS = 100_000;
/** If the round trip has grown this much since before the voice, its packets queue. */
const GROWN_MS = 60;
const BEFORE_MS = 10_000;
/** How long an encoding that was too much stays excluded. */
const EXCLUDED_MS = 15_000;
/** Packets of the previous encoding must have drained before the next is judged. */
const SETTLES_MS = 1000;

/** The rate of this encoding on the wire, headers included. */
export function wireBps({ bitrateBps, packetMs }: VoiceEncoding): number {
  return bitrateBps + (HEADER_BITS * 1000) / packetMs;
}

/**
 * Chooses the voice's encoding so that commands do not suffer, since a page cannot give them
 * priority over sound. It steps down at once where commands wait, and to null, which is silence,
 * where there is no room for both. Pure.
 */
export class EncodingChooser {
  #first = 0;
  #excludedUntilMs = Number.NEGATIVE_INFINITY;
  #judgedMs = Number.NEGATIVE_INFINITY;
  #before: { ms: number; atMs: number }[] = [];

  /** Returns the encoding from now on; call it a few times a second, `isSpeaking` or not. */
  next(uplink: Uplink, isSpeaking: boolean, nowMs: number): VoiceEncoding | null {
    const { waitingBytes, roundTripMs } = uplink;
    if (!isSpeaking && roundTripMs !== null) this.#before.push({ ms: roundTripMs, atMs: nowMs });
    if (!isSpeaking) this.#before = this.#before.filter((one) => nowMs - one.atMs < BEFORE_MS);
    if (this.#first > 0 && nowMs >= this.#excludedUntilMs) {
      this.#first--;
      this.#excludedUntilMs = nowMs + EXCLUDED_MS;
    }
    const fits = ENCODINGS.findIndex((encoding) => wireBps(encoding) * MARGIN <= roomBps(uplink));
    const chosen = fits < 0 ? ENCODINGS.length : Math.max(fits, this.#first);
    const grown = roundTripMs !== null && roundTripMs > this.#usualMs + GROWN_MS;
    const isTooMuch = isSpeaking && (waitingBytes > WAITING_BYTES || grown);
    if (!isTooMuch || nowMs - this.#judgedMs < SETTLES_MS) return ENCODINGS[chosen] ?? null;
    this.#judgedMs = nowMs;
    this.#first = Math.min(chosen + 1, ENCODINGS.length);
    this.#excludedUntilMs = nowMs + EXCLUDED_MS;
    return ENCODINGS[this.#first] ?? null;
  }

  /** The longest recent round trip without a voice. */
  get #usualMs(): number {
    if (this.#before.length === 0) return Number.POSITIVE_INFINITY;
    return Math.max(...this.#before.map((one) => one.ms));
  }
}

/** What the commands leave of the uplink. */
function roomBps({ linkBps, commandHz }: Uplink): number {
  const uplinkBps =
    linkBps === null
      ? COMMON_BPS
      : Math.max(LEAST_SHARE * linkBps, Math.min(MODEM_SHARE * linkBps, COMMON_BPS));
  return uplinkBps - commandHz * SET_POINT_BITS;
}
