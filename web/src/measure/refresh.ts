const FRAMES = 20;

/**
 * The screen's refresh interval in ms: the median gap between frames, once so many were drawn.
 * A screen draws its picture within this time, so that is how far "shown" is blurred.
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
