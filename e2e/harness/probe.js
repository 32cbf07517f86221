// Runs in the page before the page's own script: keeps hold of every peer connection and reads
// what is presented. It changes nothing that the page sees.
(() => {
  const peers = [];
  const Native = window.RTCPeerConnection;
  window.RTCPeerConnection = class extends Native {
    constructor(...args) {
      super(...args);
      peers.push(this);
    }
  };

  const peer = () => peers.filter((p) => p.connectionState !== "closed").at(-1) ?? null;
  const media = () => [...document.querySelectorAll("video, audio")];
  // The driving view, or one of the cameras beside it.
  const video = (at = 0) => media().filter((m) => m.tagName === "VIDEO")[at] ?? null;

  // --- the test card: 3 rows of 16 cells, 40 bits of Unix ms and CRC-8 -------------------
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d", { willReadFrequently: true });

  const crc8 = (bytes) => {
    let crc = 0;
    for (const byte of bytes) {
      crc ^= byte;
      for (let i = 0; i < 8; i++) crc = crc & 0x80 ? ((crc << 1) ^ 0x07) & 0xff : (crc << 1) & 0xff;
    }
    return crc;
  };

  const readCells = (element, width, height) => {
    const cellWidth = width / 16;
    const cellHeight = height / 15;
    canvas.width = width;
    canvas.height = Math.ceil(cellHeight * 3);
    context.drawImage(element, 0, 0);
    const bytes = [0, 0, 0, 0, 0, 0];
    for (let cell = 0; cell < 48; cell++) {
      const left = Math.round(((cell % 16) + 0.25) * cellWidth);
      const top = Math.round((Math.floor(cell / 16) + 0.25) * cellHeight);
      const wide = Math.max(1, Math.round(cellWidth / 2));
      const high = Math.max(1, Math.round(cellHeight / 2));
      const { data } = context.getImageData(left, top, wide, high);
      let sum = 0;
      for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
      if (sum / (data.length / 4) / 3 > 127) bytes[cell >> 3] |= 0x80 >> (cell & 7);
    }
    let stamp_ms = 0;
    for (const byte of bytes.slice(0, 5)) stamp_ms = stamp_ms * 256 + byte;
    return { stamp_ms, valid: crc8(bytes.slice(0, 5)) === bytes[5] };
  };

  // The next `count` presented frames: what the card says and how old it is by the wall clock.
  const cards = async (count, at = 0) => {
    while (video(at) === null) await new Promise((resolve) => requestAnimationFrame(resolve));
    return readFrames(count, video(at));
  };

  const readFrames = (count, element) =>
    new Promise((resolve) => {
      const found = [];
      const onFrame = (_now, metadata) => {
        const now_ms = Date.now();
        const { width, height } = metadata;
        const read = readCells(element, width, height);
        const age_ms = (now_ms % 2 ** 40) - read.stamp_ms;
        found.push({ ...read, age_ms, now_ms, width, height });
        if (found.length >= count) resolve(found);
        else element.requestVideoFrameCallback(onFrame);
      };
      element.requestVideoFrameCallback(onFrame);
    });

  // --- what the browser itself counts ----------------------------------------------------
  const counted = async (type, kind) => {
    const found = peer();
    if (!found) return null;
    for (const report of (await found.getStats()).values()) {
      if (report.type === type && report.kind === kind) return { ...report };
    }
    return null;
  };
  const inbound = (kind) => counted("inbound-rtp", kind);

  const codec = async (kind) => {
    const report = await inbound(kind);
    return report && (await peer().getStats()).get(report.codecId).mimeType;
  };

  // By which way the media come: the type of our end, how the relay is reached, the other end.
  const path = async () => {
    const all = new Map([...((await peer()?.getStats()) ?? [])]);
    const transport = [...all.values()].find((one) => one.type === "transport");
    const pair = all.get(transport?.selectedCandidatePairId);
    if (!pair) return null;
    const [local, remote] = [all.get(pair.localCandidateId), all.get(pair.remoteCandidateId)];
    const relay = local.relayProtocol ?? null;
    return { type: local.candidateType, relay, to: `${remote.address}:${remote.port}` };
  };

  window.waxProbe = {
    cards,
    codec,
    inbound,
    path,
    playing: () => {
      const v = video();
      return v !== null && !v.paused && v.readyState >= 2 && v.videoWidth > 0;
    },
    state: () => peer()?.connectionState ?? "none",
    peers: () => peers.length,
    answer: () => peer()?.remoteDescription?.sdp ?? "",
  };
})();
