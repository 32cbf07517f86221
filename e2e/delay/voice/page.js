// What the page's microphone hears, ms by ms, and when its pings were sent and received, until they
// are taken. It is listened to where LISTENS says so, because that costs the page some time. Times
// are the page's own, in ms; when a ping was received is the server's.
if (window === window.top) {
  const taken = { heard: [], pings: [] };

  const rms = (samples) => Math.sqrt(samples.reduce((sum, one) => sum + one * one, 0) / samples.length);

  const listen = async (track) => {
    const reader = new MediaStreamTrackProcessor({ track }).readable.getReader();
    for (;;) {
      const { done, value: data } = await reader.read();
      if (done) return;
      const samples = new Float32Array(data.numberOfFrames);
      data.copyTo(samples, { planeIndex: 0, format: "f32-planar" });
      const perMs = Math.round(data.sampleRate / 1000);
      const loudness = [];
      for (let i = 0; i < samples.length; i += perMs) loudness.push(rms(samples.subarray(i, i + perMs)));
      taken.heard.push([data.timestamp / 1000, loudness.map((one) => Number(one.toFixed(4)))]);
      data.close();
    }
  };

  const { mediaDevices } = navigator;
  const open = mediaDevices.getUserMedia.bind(mediaDevices);
  const listening = async (wanted) => {
    const stream = await open(wanted);
    listen(stream.getAudioTracks()[0].clone());
    return stream;
  };
  if (LISTENS) mediaDevices.getUserMedia = listening;

  // The page's window, or that of an empty frame in which it makes its peers.
  const watch = ({ RTCPeerConnection: { prototype } }) => {
    const { createDataChannel } = prototype;
    prototype.createDataChannel = function (name, ...more) {
      const channel = createDataChannel.call(this, name, ...more);
      channel.addEventListener("message", ({ data }) => {
        if (name !== "drive") return;
        const [type, , sent_page_ms, server_ms] = JSON.parse(data);
        if (type === "pong") taken.pings.push([sent_page_ms, server_ms]);
      });
      return channel;
    };
  };
  watch(window);

  window.waxVoice = {
    watch,
    sees: () => [...document.querySelectorAll("video")].some((one) => one.currentTime > 0),
    // When the page first says this, from now on.
    reads: (sentence) =>
      new Promise((resolve) => {
        const look = () => {
          if (!document.body.innerText.includes(sentence)) return;
          observer.disconnect();
          resolve(performance.now());
        };
        const observer = new MutationObserver(look);
        observer.observe(document.body, { subtree: true, childList: true, characterData: true });
        look();
      }),
    take: () => ({ heard: taken.heard.splice(0), pings: taken.pings.splice(0) }),
  };
} else if (window.frameElement) {
  window.parent.waxVoice?.watch(window);
}
