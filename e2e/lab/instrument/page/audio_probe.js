// Hears the remote sound in blocks of 10 ms, at the time at which it is played.
//
// Where there is MediaStreamTrackProcessor (Chromium) the samples are those that the playout has
// just taken out of the jitter buffer, with the moment at which it did; they need no permission, no
// script of ours under the page's policy, and pass no buffer of WebAudio's, whose filling nobody
// knows. Elsewhere WebAudio hears them (ScriptProcessor: an AudioWorklet is refused by many a page's
// policy). To both the browser's own estimate of what lies between there and the loudspeaker is
// added afterwards, by the reader.
const makeAudioProbe = (clock, hooks, limit) => {
  const table = makeTable(["taken_ms", "rms", "tone", "burst"], 60_000);
  const taps = new Map(); // of each track, its tap
  let first_ms = null;
  let last_ms = -Infinity;
  let context = null;

  // --- what 10 ms hold --------------------------------------------------------------------
  const tables = new Map();
  const waves = (hz, size) => {
    const key = `${hz}/${size}`;
    if (!tables.has(key)) {
      const angle = (i) => (2 * Math.PI * hz * 0.01 * i) / size;
      const make = (f) => Float32Array.from({ length: size }, (_, i) => f(angle(i)));
      tables.set(key, [make(Math.cos), make(Math.sin)]);
    }
    return tables.get(key);
  };
  const amplitude = (samples, hz) => {
    const [cos, sin] = waves(hz, samples.length);
    let re = 0;
    let im = 0;
    for (let i = 0; i < samples.length; i++) {
      re += samples[i] * cos[i];
      im += samples[i] * sin[i];
    }
    return (2 * Math.hypot(re, im)) / samples.length;
  };

  // --- when they are played ---------------------------------------------------------------
  // Samples follow each other at the device's even pace however unevenly it asks for them: the
  // mean of the middle half of the last second's calls says where the row of blocks lies. A call
  // that is 100 ms off is a pause, and a new row begins.
  const makePace = () => {
    let recent = [];
    let begin_ms = 0;
    let blocks = 0;
    return (taken_ms) => {
      const middle = () => {
        const sorted = recent.toSorted((a, b) => a - b);
        const part = sorted.slice(sorted.length >> 2, sorted.length - (sorted.length >> 2));
        return part.reduce((sum, value) => sum + value, 0) / part.length;
      };
      const off_ms = taken_ms - (begin_ms + 10 * blocks);
      if (recent.length === 0 || Math.abs(off_ms - middle()) > 100) {
        begin_ms = taken_ms;
        blocks = 0;
        recent = [0];
      } else {
        recent.push(off_ms);
        if (recent.length > 100) recent.shift();
      }
      return begin_ms + 10 * blocks++ + middle();
    };
  };

  const audible = (track) =>
    track.enabled &&
    track.readyState === "live" &&
    hooks
      .elements()
      .some(
        (m) =>
          !m.paused && !m.muted && m.volume > 0 && m.srcObject?.getAudioTracks?.().includes(track),
      );
  // Two at once would be heard as one: the newest that is audible counts.
  const heard = () => [...taps.keys()].findLast(audible) ?? null;

  // Takes samples of any number, with the page's time of the first of them.
  const makeTap = (track) => {
    const pace = makePace();
    let block = new Float32Array(0);
    let filled = 0;
    let block_ms = 0;
    const feed = (samples, rate_hz, taken_ms) => {
      const size = Math.round(rate_hz / 100);
      if (block.length !== size) {
        block = new Float32Array(size);
        filled = 0;
      }
      for (let i = 0; i < samples.length; i++) {
        if (filled === 0) block_ms = taken_ms + (i * 1000) / rate_hz;
        block[filled++] = samples[i];
        if (filled < size) continue;
        filled = 0;
        finish(block_ms);
      }
    };
    const finish = (taken_ms) => {
      const even_ms = pace(taken_ms);
      if (heard() !== track) return;
      const at_ms = clock.unix(even_ms);
      let sum = 0;
      for (const sample of block) sum += sample * sample;
      const rms = Math.sqrt(sum / block.length);
      if (rms > 0.001) first_ms ??= at_ms;
      last_ms = performance.now();
      const [tone, burst] = [amplitude(block, 300), amplitude(block, 1000)];
      table.add(rounded(at_ms, 2), rounded(rms, 4), rounded(tone, 4), rounded(burst, 4));
    };
    return { feed };
  };

  // --- the two ways to the samples --------------------------------------------------------
  const process = async (track) => {
    const { feed } = makeTap(track);
    const reader = new MediaStreamTrackProcessor({ track, maxBufferSize: 100 }).readable.getReader();
    // The samples' own clock is monotonic like the page's, with another origin: the quickest
    // delivery so far tells it, to the fraction of a millisecond that it took.
    let origin_ms = Infinity;
    let samples = new Float32Array(480);
    for (;;) {
      const { value, done } = await reader.read();
      if (done) break;
      const { timestamp, numberOfFrames, sampleRate } = value;
      origin_ms = Math.min(origin_ms, performance.now() - timestamp / 1000);
      if (samples.length !== numberOfFrames) samples = new Float32Array(numberOfFrames);
      value.copyTo(samples, { planeIndex: 0, format: "f32-planar" });
      value.close();
      feed(samples, sampleRate, timestamp / 1000 + origin_ms);
    }
    taps.delete(track);
  };

  const listenByWebAudio = (track) => {
    const { feed } = makeTap(track);
    const source = context.createMediaStreamSource(new MediaStream([track]));
    const meter = context.createScriptProcessor(512, 1, 1);
    meter.onaudioprocess = ({ inputBuffer }) => {
      const { length, sampleRate } = inputBuffer;
      const samples = inputBuffer.getChannelData(0);
      feed(samples, sampleRate, performance.now() - (length * 1000) / sampleRate);
    };
    source.connect(meter);
    meter.connect(context.destination); // it is silent, but runs only when it leads somewhere
    track.addEventListener("ended", () => {
      source.disconnect();
      meter.disconnect();
      taps.delete(track);
    });
    return { source, meter };
  };

  const direct = "MediaStreamTrackProcessor" in window;
  hooks.on("track", (track) => {
    if (!direct) return;
    taps.set(track, null);
    process(track).catch((error) => limit(`The sound cannot be tapped: ${error}.`));
  });

  const NO_DEVICE =
    "This browser has no sound device to run WebAudio on: the age of the sound and its pauses are not heard.";
  const listen = async () => {
    if (!direct) {
      context ??= new AudioContext();
      // Where there is no device this waits for ever.
      await Promise.race([context.resume(), new Promise((done) => setTimeout(done, 1000))]);
      limit(NO_DEVICE, context.state !== "running");
      if (context.state !== "running") return false;
      limit("The sound is heard through WebAudio, whose own buffer is in its age.");
      for (const track of hooks.remoteTracks) {
        if (!taps.has(track)) taps.set(track, listenByWebAudio(track));
      }
    }
    return performance.now() - last_ms < 500;
  };

  return {
    table,
    listen,
    first_ms: () => first_ms,
    context_output_ms: () => (context ? 1000 * (context.outputLatency ?? 0) : null),
  };
};
