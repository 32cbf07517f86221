// Promises when a second, different picture is presented, ms since the navigation; null after 90 s.
(() => {
  window.waxMovingMs = new Promise((resolve) => {
    const watched = new WeakSet();
    const watch = (video) => {
      if (watched.has(video)) return;
      watched.add(video);
      let first = null;
      const onFrame = (_now, { rtpTimestamp, mediaTime }) => {
        const picture = rtpTimestamp ?? mediaTime;
        first ??= picture;
        if (picture !== first) resolve(performance.now());
        else video.requestVideoFrameCallback(onFrame);
      };
      video.requestVideoFrameCallback(onFrame);
    };
    const look = () => document.querySelectorAll("video").forEach(watch);
    new MutationObserver(look).observe(document, { childList: true, subtree: true });
    setTimeout(() => resolve(null), 90_000);
  });
})();
