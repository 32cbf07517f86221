// Records the page's tasks of more than 50 ms, and the rate at which it presents pictures.
(() => {
  window.waxLongTasks = [];
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) window.waxLongTasks.push(duration);
  }).observe({ type: "longtask" });

  // Returns the pictures presented a second, averaged over at least `ms`.
  window.waxPresented = (ms) =>
    new Promise((resolve) => {
      const video = document.querySelector("video");
      let first = null;
      const onFrame = (now, { presentedFrames }) => {
        first ??= { now, presentedFrames };
        const took = now - first.now;
        if (took >= ms) resolve(((presentedFrames - first.presentedFrames) / took) * 1000);
        else video.requestVideoFrameCallback(onFrame);
      };
      video.requestVideoFrameCallback(onFrame);
    });
})();
