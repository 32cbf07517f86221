/** The two counters of `inbound-rtp` from which the delay in the jitter buffer follows. */
export interface BufferCounters {
  jitterBufferDelay?: number;
  jitterBufferEmittedCount?: number;
}

/** Mean delay in a jitter buffer between two looks at its counters (webrtc-stats 8.2.1). */
export class DelayMeter {
  #last: Required<BufferCounters> | null = null;

  /** The mean in ms since the last call; null at first, and when nothing came out. */
  next({ jitterBufferDelay, jitterBufferEmittedCount }: BufferCounters): number | null {
    if (jitterBufferDelay === undefined || jitterBufferEmittedCount === undefined) return null;
    const last = this.#last;
    this.#last = { jitterBufferDelay, jitterBufferEmittedCount };
    if (!last) return null;
    const count = jitterBufferEmittedCount - last.jitterBufferEmittedCount;
    return count > 0 ? ((jitterBufferDelay - last.jitterBufferDelay) / count) * 1000 : null;
  }
}

/** The counters of the one stream that this receiver receives. */
export async function bufferCounters(receiver: RTCRtpReceiver): Promise<BufferCounters> {
  for (const report of (await receiver.getStats()).values()) {
    if (report.type === "inbound-rtp") return report;
  }
  return {};
}
