/**
 * A transform that reports each complete frame: a picture arrives here after its last packet, sound
 * packet by packet (W3C, WebRTC Encoded Transform).
 */

interface Transformer {
  readable: ReadableStream<{ timestamp?: number; getMetadata(): { rtpTimestamp?: number } }>;
  writable: WritableStream;
  options: "audio" | "video";
}

/** The report to the page; `rtp` is the frame's RTP time. */
export interface Arrival {
  kind: "audio" | "video";
  rtp: number;
}

addEventListener("rtctransform", (event) => {
  const { transformer } = event as Event & { transformer: Transformer };
  const { readable, writable, options: kind } = transformer;
  const noting = new TransformStream({
    transform(frame, controller) {
      const rtp = frame.getMetadata().rtpTimestamp ?? frame.timestamp;
      if (rtp !== undefined) postMessage({ kind, rtp } satisfies Arrival);
      controller.enqueue(frame);
    },
  });
  // The stream ends when the page closes the connection, which is no error.
  void readable
    .pipeThrough(noting)
    .pipeTo(writable)
    .catch(() => {});
});

// A transform created before this message would never get its streams.
postMessage("ready");
