// Reads the largest playing video, frame by frame, as it is presented.
//
// "Presented" is `presentationTime`: when the browser gave the frame to its compositor, which is at
// a display refresh. The callback itself may be up to a refresh later, or more on a busy page;
// `expectedDisplayTime` is a prediction. Not included is the time from there to the screen's light:
// up to one refresh, and the screen's own delay, the same for every system.
const makeVideoProbe = (clock, hooks) => {
  const COLUMNS = 16;
  const ROWS = 3;
  const FINE = 3; // drawn with 3 × 3 samples a cell, of which the middle one is read
  const table = makeTable(["at_ms", "stamp40_ms", "received_ms", "width", "height"], 36_000);
  let first_ms = null;
  let chosen = null;

  const makeContext = (width, height) => {
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = height;
    return canvas.getContext("2d", { willReadFrequently: true });
  };
  const small = makeContext(COLUMNS * FINE, ROWS * FINE);
  small.imageSmoothingQuality = "medium"; // averages over what a sample stands for

  const crc8 = (bytes) => {
    let crc = 0;
    for (const byte of bytes) {
      crc ^= byte;
      for (let i = 0; i < 8; i++) crc = crc & 0x80 ? ((crc << 1) ^ 0x07) & 0xff : (crc << 1) & 0xff;
    }
    return crc;
  };

  // The 40 bits of the card, null where its check is wrong; `isWhite(row, column)` tells a cell.
  const decode = (isWhite) => {
    const bytes = [0, 0, 0, 0, 0, 0];
    for (let cell = 0; cell < COLUMNS * ROWS; cell++) {
      if (isWhite(Math.floor(cell / COLUMNS), cell % COLUMNS)) bytes[cell >> 3] |= 0x80 >> (cell & 7);
    }
    const stamp = bytes.slice(0, 5).reduce((sum, byte) => sum * 256 + byte, 0);
    return stamp !== 0 && crc8(bytes.slice(0, 5)) === bytes[5] ? stamp : null;
  };

  // Only the brightness of the top fifth is copied; to draw it, the whole frame would be converted.
  const hasLuma = (frame) => /^(I4|NV12)/.test(frame.format ?? "");
  let luma = new Uint8Array(0);
  const stampOfLuma = async (frame) => {
    const { x, y, width, height } = frame.visibleRect;
    const rect = { x, y, width: width & ~1, height: Math.floor(height / 5) & ~1 };
    const size = frame.allocationSize({ rect });
    if (luma.length < size) luma = new Uint8Array(size);
    const plane = luma;
    const [{ offset, stride }] = await frame.copyTo(plane, { rect });
    return decode((row, column) => {
      // The inner half of the cell: its edges are blurred by scaling and by the codec.
      const [top, bottom] = [1, 3].map((n) => Math.floor(((4 * row + n) * height) / 60));
      const [left, right] = [1, 3].map((n) => Math.floor(((4 * column + n) * width) / 64));
      let sum = 0;
      for (let v = top; v < bottom; v++) {
        for (let u = left; u < right; u++) sum += plane[offset + v * stride + u];
      }
      return sum > 126 * (bottom - top) * (right - left);
    });
  };
  const stampOfDrawing = (video) => {
    const { videoWidth, videoHeight } = video;
    const { width, height } = small.canvas;
    small.drawImage(video, 0, 0, videoWidth, videoHeight / 5, 0, 0, width, height);
    const { data } = small.getImageData(0, 0, width, height);
    return decode((row, column) => {
      const at = 4 * ((row * FINE + 1) * width + column * FINE + 1);
      return data[at] + data[at + 1] + data[at + 2] > 382;
    });
  };

  let byLuma = "VideoFrame" in window; // until a frame shows that this browser has none to give
  const read = async (video, at_ms, mediaTime_s, received_ms) => {
    const { videoWidth, videoHeight } = video;
    let frame = null;
    try {
      if (byLuma) {
        frame = new VideoFrame(video);
        byLuma = hasLuma(frame);
      }
      // The page was so late that the next frame is there already: that one's turn will come.
      if (byLuma && Math.abs(frame.timestamp - 1e6 * mediaTime_s) > 5) return;
      const stamp = byLuma ? await stampOfLuma(frame) : stampOfDrawing(video);
      table.add(rounded(at_ms, 2), stamp, rounded(received_ms, 2), videoWidth, videoHeight);
    } finally {
      frame?.close();
    }
  };

  // The brightness of the whole picture that stands there, kept here until the readings are over: to
  // hand one over takes the page longer than a picture lasts.
  const seen = [];
  const lookOnce = async () => {
    const at_ms = clock.now();
    const frame = new VideoFrame(chosen);
    try {
      if (!hasLuma(frame)) return;
      const plane = new Uint8Array(frame.allocationSize());
      const [{ offset, stride }] = await frame.copyTo(plane);
      const { width, height } = frame.visibleRect;
      const luma = plane.slice(offset, offset + stride * height);
      seen.push({ at_ms, width, height, stride, luma });
    } finally {
      frame.close();
    }
  };
  const look = (times, every_ms) => {
    if (chosen) lookOnce().catch((error) => console.debug(error));
    if (times > 1) setTimeout(look, every_ms, times - 1, every_ms);
  };
  const handOver = () => {
    const one = seen.shift();
    return one ? { ...one, luma: one.luma.toBase64() } : null;
  };

  const area = (video) => 1e6 * video.clientWidth * video.clientHeight + video.videoWidth;
  const plays = (video) =>
    !video.paused &&
    video.readyState >= 2 &&
    video.srcObject?.getVideoTracks?.().some((track) => track.readyState === "live");
  const choose = () => {
    const playing = hooks.elements().filter((m) => m instanceof HTMLVideoElement && plays(m));
    chosen = playing.sort((a, b) => area(b) - area(a))[0] ?? null;
  };

  hooks.on("element", (video) => {
    if (!(video instanceof HTMLVideoElement)) return;
    const onFrame = (_now, frame) => {
      video.requestVideoFrameCallback(onFrame);
      const at_ms = clock.unix(frame.presentationTime);
      first_ms ??= at_ms;
      if (!chosen || !plays(chosen)) choose();
      if (video !== chosen) return;
      const received_ms = frame.receiveTime ? clock.unix(frame.receiveTime) : null;
      read(video, at_ms, frame.mediaTime, received_ms).catch((error) => console.debug(error));
    };
    video.requestVideoFrameCallback(onFrame);
  });

  return {
    choose,
    table,
    look,
    handOver,
    sees: () => first_ms !== null,
    first_ms: () => first_ms,
  };
};
