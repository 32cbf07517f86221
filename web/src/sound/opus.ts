/** The duration of an Opus packet, by its header (RFC 6716, 3.1). Pure. */

/** Opus in RTP always counts 48,000 samples a second (RFC 7587, 4.1). */
export const OPUS_HZ = 48_000;

const SILK_TICKS = [480, 960, 1920, 2880];
const HYBRID_TICKS = [480, 960];
const CELT_TICKS = [120, 240, 480, 960];

/** Returns how many samples a packet holds, 0 if it is malformed. */
export function opusTicks(packet: Uint8Array): number {
  const [toc, count] = packet;
  if (toc === undefined) return 0;
  const config = toc >> 3;
  const code = toc & 0x03;
  const frames = code === 0 ? 1 : code < 3 ? 2 : (count ?? 0) & 0x3f;
  const ticks = frames * frameTicks(config);
  return ticks <= 0.12 * OPUS_HZ ? ticks : 0;
}

function frameTicks(config: number): number {
  const of =
    config < 12
      ? SILK_TICKS[config & 3]
      : config < 16
        ? HYBRID_TICKS[config & 1]
        : CELT_TICKS[config & 3];
  return of ?? 0;
}
