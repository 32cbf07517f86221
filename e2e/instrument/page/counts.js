// Reads the browser's own counts every 100 ms, summed over all peer connections since the opening:
// the counts of a closed one stay in the sum, so that sums never fall.
const makeCounts = (clock, hooks) => {
  const numbers = new WeakMap(); // each peer's number
  const seen = new Map(); // the last version of each report that counts something
  let peerCount = 0;
  let before = null;

  const sum = (reports, field) => {
    let total = null;
    for (const report of reports) {
      const value = report[field];
      if (typeof value === "number") total = (total ?? 0) + value;
    }
    return total;
  };
  const held_ms = (sound) => {
    const delay_s = sum(sound, "jitterBufferDelay");
    const samples = sum(sound, "jitterBufferEmittedCount");
    const last = before;
    before = { delay_s, samples };
    if (delay_s === null || !last || samples <= last.samples) return null;
    return (1000 * (delay_s - last.delay_s)) / (samples - last.samples);
  };
  const COLUMNS = {
    played_samples: (sound) => sum(sound, "totalSamplesReceived"),
    concealed_samples: (sound) => sum(sound, "concealedSamples"),
    concealment_events: (sound) => sum(sound, "concealmentEvents"),
    stretched_samples: (sound) => sum(sound, "insertedSamplesForDeceleration"),
    sound_buffer_ms: held_ms,
    received_bytes: (_sound, transports) => sum(transports, "bytesReceived"),
    sent_bytes: (_sound, transports) => sum(transports, "bytesSent"),
  };
  const table = makeTable(["at_ms", ...Object.keys(COLUMNS)], 6000);

  const COUNTED = new Set(["inbound-rtp", "transport"]);
  const look = async () => {
    for (const peer of [...hooks.peers]) {
      if (!numbers.has(peer)) numbers.set(peer, peerCount++);
      const number = numbers.get(peer);
      for (const report of (await peer.getStats()).values()) {
        if (COUNTED.has(report.type)) seen.set(`${number}/${report.id}`, report);
      }
    }
    if (seen.size === 0) return;
    const reports = [...seen.values()];
    const sound = reports.filter(({ type, kind }) => type === "inbound-rtp" && kind === "audio");
    const transports = reports.filter(({ type }) => type === "transport");
    const row = Object.values(COLUMNS).map((count) => rounded(count(sound, transports), 2));
    table.add(rounded(clock.now(), 1), ...row);
  };
  return { look, table };
};
