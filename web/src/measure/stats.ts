/** A receiver's counters (W3C webrtc-stats); browsers lack some of them. */

import { Unsettled, within } from "../within";

export interface InboundStats {
  codecId?: string;
  packetsReceived?: number;
  /** In seconds. */
  jitter?: number;
  jitterBufferDelay?: number;
  jitterBufferEmittedCount?: number;
  totalSamplesReceived?: number;
  concealedSamples?: number;
  concealmentEvents?: number;
  insertedSamplesForDeceleration?: number;
  framesReceived?: number;
  framesDecoded?: number;
  freezeCount?: number;
  totalFreezesDuration?: number;
  audioLevel?: number;
}

export interface PlayoutStats {
  totalPlayoutDelay?: number;
  totalSamplesCount?: number;
}

export interface ReceiverStats {
  inbound: InboundStats;
  playout: PlayoutStats;
  clockHz: number;
}

/** The RTP clock rate of Opus (RFC 7587). */
const OPUS_HZ = 48_000;

/** Receivers that have never answered; the ages come from elsewhere and are reported all the same. */
const silent = new WeakSet<RTCRtpReceiver>();

/** Reads the counters of this receiver's stream; none if the browser never answers. */
export async function readStats(receiver: RTCRtpReceiver): Promise<ReceiverStats> {
  const none = new Map() as RTCStatsReport;
  const stats = silent.has(receiver)
    ? none
    : await within("getStats", receiver.getStats()).catch((error) => {
        if (!(error instanceof Unsettled)) throw error;
        silent.add(receiver);
        return none;
      });
  const all = [...stats.values()];
  const inbound: InboundStats = all.find((one) => one.type === "inbound-rtp") ?? {};
  return {
    inbound,
    playout: all.find((one) => one.type === "media-playout") ?? {},
    clockHz: stats.get(inbound.codecId ?? "")?.clockRate ?? OPUS_HZ,
  };
}
