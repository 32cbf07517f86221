/** Redundant audio: packets that repeat earlier sound (RFC 2198). Pure. */

/** One Opus packet; `rtp` is the RTP time of its first sample. */
export interface Block {
  rtp: number;
  data: Uint8Array;
}

const MORE = 0x80;
const HEADER_BYTES = 4;

/** Returns the packets in a payload, oldest first; none if it is malformed. */
export function splitRed(payload: Uint8Array, rtp: number): Block[] {
  const heads: { ticks: number; bytes: number }[] = [];
  let at = 0;
  for (; (payload[at] ?? 0) & MORE; at += HEADER_BYTES) {
    const head = payload.subarray(at, at + HEADER_BYTES);
    if (head.length < HEADER_BYTES) return [];
    const [, high = 0, middle = 0, low = 0] = head;
    heads.push({ ticks: (high << 6) | (middle >> 2), bytes: ((middle & 0x03) << 8) | low });
  }
  at += 1; // the newest packet has a one-byte header, and takes the rest of the payload
  const blocks: Block[] = [];
  for (const { ticks, bytes } of heads) {
    const data = payload.subarray(at, at + bytes);
    if (data.length < bytes) return [];
    blocks.push({ rtp: (rtp - ticks) >>> 0, data });
    at += bytes;
  }
  if (at >= payload.length) return [];
  return [...blocks, { rtp, data: payload.subarray(at) }];
}
