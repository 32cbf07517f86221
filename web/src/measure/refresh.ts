const FRAMES = 20;

/**
 * Resolves to the screen's refresh interval in ms: the median gap between animation frames. A
 * screen draws a frame within this time, which is the uncertainty of "shown".
 */
export function measureRefresh(): Promise<number> {
  return new Promise((resolve) => {
    const gapsMs: number[] = [];
    let lastMs: number | null = null;
    const onFrame = (nowMs: number) => {
      if (lastMs !== null && nowMs > lastMs) gapsMs.push(nowMs - lastMs);
      lastMs = nowMs;
      if (gapsMs.length < FRAMES) requestAnimationFrame(onFrame);
      else resolve(gapsMs.sort((a, b) => a - b)[FRAMES >> 1] ?? 0);
    };
    requestAnimationFrame(onFrame);
  });
}
