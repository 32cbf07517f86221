import { OPUS_HZ } from "../sound/opus";
import { SoundPlayer } from "../sound/soundPlayer";

/** One packet of a trace: when it was sent and when it arrived, in ms; lost ones are left out. */
export interface Arrival {
  sentMs: number;
  arrivedMs: number;
}

export interface Heard {
  /** From sending a sample to playing it, for each 10 ms that were not concealed. */
  agesMs: number[];
  concealedShare: number;
  stretchedShare: number;
  droppedShare: number;
}

const BLOCK = 128;
const MS = OPUS_HZ / 1000;
const PACKET_MS = 20;
/** Six periods of a 300 Hz tone: each packet continues where the previous one ended. */
const PACKET = Float32Array.from(
  { length: PACKET_MS * MS },
  (_, i) => 0.5 * Math.sin((2 * Math.PI * 300 * i) / OPUS_HZ),
);

/**
 * Plays a trace of 20 ms packets in simulated time. `driftPpm` is by how much the device's clock is
 * faster than the sender's. The first `settleMs` do not count. Pure.
 */
export function simulate(
  trace: Arrival[],
  { driftPpm = 0, settleMs = 3000 }: Partial<Settings> = {},
): Heard {
  const player = new SoundPlayer();
  const byArrival = trace.toSorted((a, b) => a.arrivedMs - b.arrivedMs);
  const endMs = Math.max(...trace.map((one) => one.sentMs));
  const perMs = MS * (1 + driftPpm / 1e6);
  const out = new Float32Array(BLOCK);
  const agesMs: number[] = [];
  let before = { ...player.counts };
  let next = 0;
  let isSettled = false;
  for (let frame = 0; frame / perMs < endMs; frame += BLOCK) {
    const nowMs = frame / perMs;
    for (; next < byArrival.length; next++) {
      const one = byArrival[next];
      if (!one || one.arrivedMs > nowMs) break;
      // The packet is sent once its last sample has been captured.
      player.arrive(RTP_ORIGIN + (one.sentMs - PACKET_MS) * MS, [PACKET], frame);
    }
    player.render([out], frame);
    if (!isSettled && nowMs >= settleMs) {
      isSettled = true;
      before = { ...player.counts };
    }
    const { rtp } = player;
    if (isSettled && rtp !== null && (frame / BLOCK) % 4 === 0) {
      agesMs.push(nowMs + BLOCK / MS - (rtp - RTP_ORIGIN) / MS);
    }
  }
  const { counts } = player;
  const share = (of: "concealed" | "stretched" | "dropped") =>
    (counts[of] - before[of]) / Math.max(1, counts.played - before.played);
  return {
    agesMs,
    concealedShare: share("concealed"),
    stretchedShare: share("stretched"),
    droppedShare: share("dropped"),
  };
}

interface Settings {
  driftPpm: number;
  settleMs: number;
}

/** Not zero, so that no test relies on zero. */
const RTP_ORIGIN = 480_000;
