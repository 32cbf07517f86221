// Runs in the page before the page's own script: notes when it shows a new picture, whose that is,
// and what it says, with the Unix time in ms. It changes nothing that the page sees.
(() => {
  const unix = (pageMs) => Date.now() - (performance.now() - pageMs);

  // The robot's own server is who gets the channel of the room's state; LiveKit has channels of its own.
  // The page makes its peers in an empty frame of its own, in which this runs, too.
  const home = window.frameElement ? window.parent : window;
  const servers = (home.waxServers ??= []);
  const create = RTCPeerConnection.prototype.createDataChannel;
  RTCPeerConnection.prototype.createDataChannel = function (label, ...rest) {
    if (label === "state") servers.push(this);
    return create.call(this, label, ...rest);
  };
  const isServers = (track) =>
    servers.some((peer) => peer.getReceivers().some((one) => one.track === track));

  const pictures = []; // ms
  const places = []; // [ms, "server" or "room"]
  const watch = (video) => {
    let before = null;
    const onFrame = (_nowMs, { presentationTime, rtpTimestamp, mediaTime }) => {
      video.requestVideoFrameCallback(onFrame);
      const track = video.srcObject?.getVideoTracks()[0];
      const picture = rtpTimestamp ?? mediaTime;
      if (!track || picture === before) return; // the same one, shown again
      before = picture;
      const place = isServers(track) ? "server" : "room";
      pictures.push(unix(presentationTime));
      if (places.at(-1)?.[1] !== place) places.push([unix(presentationTime), place]);
    };
    video.requestVideoFrameCallback(onFrame);
  };

  const texts = { status: "[role=status]", turn: "section[aria-label=Turn]" };
  const said = { status: [], turn: [] }; // [ms, text]
  const watched = new WeakSet();
  const look = () => {
    for (const [name, selector] of Object.entries(texts)) {
      const text = document.querySelector(selector)?.textContent ?? "";
      if (text !== said[name].at(-1)?.[1]) said[name].push([unix(performance.now()), text]);
    }
    for (const video of document.querySelectorAll("video")) {
      if (!watched.has(video)) watch(video);
      watched.add(video);
    }
  };
  const everything = { subtree: true, childList: true, characterData: true };
  new MutationObserver(look).observe(document, everything);

  window.waxPage = { pictures, places, said };
})();
