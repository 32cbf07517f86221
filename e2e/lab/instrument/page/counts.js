// Looks at the browser's own counts every 100 ms, over all peer connections that there ever were:
// what a closed one had counted stays in the sum, so that sums never fall.
const makeCounts = (clock, hooks, limit) => {
  const COLUMNS = [
    "played_samples",
    "concealed_samples",
    "concealment_events",
    "frames_decoded",
    "sound_buffer_ms",
    "picture_buffer_ms",
    "round_trip_ms",
    "audio_bytes",
    "video_bytes",
    "repeated_bytes",
    "received_bytes",
    "sent_bytes",
    "data_received_bytes",
    "data_sent_bytes",
    "output_ms",
  ];
  const table = makeTable(["at_ms", ...COLUMNS], 6000);
  const numbers = new WeakMap(); // of each peer, a number
  const seen = new Map(); // of each report ever seen that counts something, the last
  let peerCount = 0;
  let before = {};

  const sum = (reports, field) => {
    let total = null;
    for (const report of reports) {
      const value = typeof field === "function" ? field(report) : report[field];
      if (typeof value === "number") total = (total ?? 0) + value;
    }
    return total;
  };
  const perItem_ms = (name, delay_s, items) => {
    const last = before[name];
    before[name] = { delay_s, items };
    if (delay_s === null || !last || items <= last.items) return null;
    return (1000 * (delay_s - last.delay_s)) / (items - last.items);
  };

  // Repeated packets are counted in `bytesReceived` too; of their headers only the mean is known.
  const header = (r) => (r.packetsReceived ? r.headerBytesReceived / r.packetsReceived : 0);
  const repeated = (r) => {
    if (r.retransmittedBytesReceived === undefined) return r.rtxSsrc === undefined ? undefined : 0;
    return r.retransmittedBytesReceived + r.retransmittedPacketsReceived * header(r);
  };
  const whole = (r) => r.bytesReceived + (r.headerBytesReceived ?? 0);

  const COUNTED = new Set(["inbound-rtp", "data-channel", "transport", "candidate-pair", "media-playout"]);
  const look = async () => {
    for (const peer of [...hooks.peers]) {
      if (!numbers.has(peer)) numbers.set(peer, peerCount++);
      const number = numbers.get(peer);
      for (const report of (await peer.getStats()).values()) {
        if (COUNTED.has(report.type)) seen.set(`${number}/${report.id}`, { number, ...report });
      }
    }
    if (seen.size === 0) return;
    const of = (type, kind) =>
      [...seen.values()].filter((r) => r.type === type && (!kind || r.kind === kind));
    const sound = of("inbound-rtp", "audio");
    const picture = of("inbound-rtp", "video");
    const channels = of("data-channel");
    // Only Chromium counts by transport; else by the pairs of addresses that it ran over.
    const transports = of("transport").filter((r) => r.bytesReceived !== undefined);
    const pairs = of("candidate-pair");
    const carriers = transports.length ? transports : pairs;
    const selected = new Set(of("transport").map((r) => `${r.number}/${r.selectedCandidatePairId}`));
    const live = new Set(hooks.peers.map((peer) => numbers.get(peer)));
    const busiest = pairs
      .filter((r) => live.has(r.number) && selected.has(`${r.number}/${r.id}`))
      .sort((a, b) => b.bytesReceived - a.bytesReceived)[0];
    const trip_s = busiest?.currentRoundTripTime;
    const again = sum(picture, repeated);
    const video = sum(picture, (r) => whole(r) - (repeated(r) ?? 0));
    if (picture.some((r) => r.packetsReceived > 0)) {
      limit("This browser does not count what was sent again: it is among the video.", again === null);
    }
    const row = {
      played_samples: sum(sound, "totalSamplesReceived"),
      concealed_samples: sum(sound, "concealedSamples"),
      concealment_events: sum(sound, "concealmentEvents"),
      frames_decoded: sum(picture, "framesDecoded"),
      sound_buffer_ms: perItem_ms(
        "sound",
        sum(sound, "jitterBufferDelay"),
        sum(sound, "jitterBufferEmittedCount"),
      ),
      picture_buffer_ms: perItem_ms(
        "picture",
        sum(picture, "jitterBufferDelay"),
        sum(picture, "jitterBufferEmittedCount"),
      ),
      round_trip_ms: trip_s === undefined ? null : 1000 * trip_s,
      audio_bytes: sum(sound, whole),
      video_bytes: video,
      repeated_bytes: again,
      received_bytes: sum(carriers, "bytesReceived"),
      sent_bytes: sum(carriers, "bytesSent"),
      data_received_bytes: sum(channels, "bytesReceived"),
      data_sent_bytes: sum(channels, "bytesSent"),
      output_ms: perItem_ms(
        "output",
        sum(of("media-playout"), "totalPlayoutDelay"),
        sum(of("media-playout"), "totalSamplesCount"),
      ),
    };
    table.add(rounded(clock.now(), 1), ...COLUMNS.map((name) => rounded(row[name], 2)));
  };

  // What the browser reckons between the jitter buffer and the loudspeaker, mean over all samples.
  const output_ms = () => {
    const reports = [...seen.values()].filter((r) => r.type === "media-playout");
    const samples = sum(reports, "totalSamplesCount");
    return samples ? (1000 * sum(reports, "totalPlayoutDelay")) / samples : null;
  };
  return { look, table, output_ms };
};
