// An AudioWorklet that turns sound into blocks of 10 ms: when it was heard (Unix ms), its RMS, and
// the amplitude of the test card's two tones.
const wallOffsets = [];

class Meter extends AudioWorkletProcessor {
  constructor() {
    super();
    this.size = Math.round(sampleRate / 100);
    this.samples = new Float32Array(this.size);
    this.filled = 0;
    this.ready = [];
  }

  // The device asks for sound in bursts: the earliest of the latest calls is the true clock.
  wallMs() {
    wallOffsets.push(Date.now() - currentTime * 1000);
    if (wallOffsets.length > 400) wallOffsets.shift();
    return currentTime * 1000 + Math.min(...wallOffsets);
  }

  amplitude(hz) {
    let re = 0;
    let im = 0;
    for (let i = 0; i < this.size; i++) {
      const angle = (2 * Math.PI * hz * i) / sampleRate;
      re += this.samples[i] * Math.cos(angle);
      im += this.samples[i] * Math.sin(angle);
    }
    return (2 * Math.hypot(re, im)) / this.size;
  }

  process([[input]]) {
    const start_ms = this.wallMs();
    for (let i = 0; i < (input?.length ?? 128); i++) {
      this.samples[this.filled++] = input ? input[i] : 0;
      if (this.filled < this.size) continue;
      this.filled = 0;
      let sum = 0;
      for (const sample of this.samples) sum += sample * sample;
      this.ready.push({
        start_ms: start_ms + ((i + 1 - this.size) * 1000) / sampleRate,
        rms: Math.sqrt(sum / this.size),
        tone: this.amplitude(300),
        burst: this.amplitude(1000),
      });
    }
    if (this.ready.length >= 10) {
      this.port.postMessage(this.ready);
      this.ready = [];
    }
    return true;
  }
}

registerProcessor("wax-meter", Meter);
