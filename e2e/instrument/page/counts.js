// Looks at the browser's own counts every 100 ms, over all peer connections that there ever were:
// what a closed one had counted stays in the sum, so that sums never fall.
const makeCounts = (clock, hooks) => {
  const COLUMNS = [
    "played_samples",
    "concealed_samples",
    "concealment_events",
    "stretched_samples",
    "sound_buffer_ms",
    "received_bytes",
    "sent_bytes",
  ];
  const table = makeTable(["at_ms", ...COLUMNS], 6000);
  const numbers = new WeakMap(); // of each peer, a number
  const seen = new Map(); // of each report ever seen that counts something, the last
  let peerCount = 0;
  let before = {};

  const sum = (reports, field) => {
    let total = null;
    for (const report of reports) {
      const value = report[field];
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

  const COUNTED = new Set(["inbound-rtp", "transport"]);
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
    const transports = of("transport");
    const row = {
      played_samples: sum(sound, "totalSamplesReceived"),
      concealed_samples: sum(sound, "concealedSamples"),
      concealment_events: sum(sound, "concealmentEvents"),
      stretched_samples: sum(sound, "insertedSamplesForDeceleration"),
      sound_buffer_ms: perItem_ms(
        "sound",
        sum(sound, "jitterBufferDelay"),
        sum(sound, "jitterBufferEmittedCount"),
      ),
      received_bytes: sum(transports, "bytesReceived"),
      sent_bytes: sum(transports, "bytesSent"),
    };
    table.add(rounded(clock.now(), 1), ...COLUMNS.map((name) => rounded(row[name], 2)));
  };
  return { look, table };
};
