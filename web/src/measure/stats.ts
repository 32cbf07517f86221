/** What a receiver counts (W3C webrtc-stats): each field is missing where a browser has it not. */

export interface InboundStats {
  codecId?: string;
  packetsReceived?: number;
  jitterBufferDelay?: number;
  jitterBufferEmittedCount?: number;
  totalSamplesReceived?: number;
  concealedSamples?: number;
  concealmentEvents?: number;
  framesDecoded?: number;
  freezeCount?: number;
  totalFreezesDuration?: number;
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

/** Of Opus, in whatever form (RFC 7587). */
const OPUS_HZ = 48_000;

/** One look at the one stream that this receiver receives. */
export async function look(receiver: RTCRtpReceiver): Promise<ReceiverStats> {
  const stats = await receiver.getStats();
  const all = [...stats.values()];
  const inbound: InboundStats = all.find((one) => one.type === "inbound-rtp") ?? {};
  return {
    inbound,
    playout: all.find((one) => one.type === "media-playout") ?? {},
    clockHz: stats.get(inbound.codecId ?? "")?.clockRate ?? OPUS_HZ,
  };
}
