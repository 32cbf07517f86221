import { useEffect, useRef } from "preact/hooks";
import { useState } from "../view/context";
import { t } from "../words/words";
import { HEIGHT, MARGIN, patches, WIDTH } from "./code";
import { serverMsAt } from "./serverTime";

/** After a pause of the page nobody knows for how long a frame will be shown. */
const LONGEST_FRAME_MS = 50;

/** The code of the server's time, painted anew for each frame of the screen. */
export function TimeCode() {
  const state = useState();
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const element = canvas.current;
    const context = element?.getContext("2d", { alpha: false });
    if (!element || !context) return;
    let before = performance.now();
    let handle = 0;
    const onFrame = (atMs: number) => {
      handle = requestAnimationFrame(onFrame);
      // A camera sees the frame for as long as the screen keeps it: the middle of that is its time.
      const lastsMs = Math.min(Math.max(0, atMs - before), LONGEST_FRAME_MS);
      before = atMs;
      const serverMs = serverMsAt(state, atMs + lastsMs / 2);
      if (serverMs !== null) paint(element, context, serverMs);
    };
    handle = requestAnimationFrame(onFrame);
    return () => cancelAnimationFrame(handle);
  }, [state]);
  return <canvas ref={canvas} class="glass-code" role="img" aria-label={t("glass.code")} />;
}

function paint(
  canvas: HTMLCanvasElement,
  context: CanvasRenderingContext2D,
  serverMs: number,
): void {
  const width = Math.round(canvas.clientWidth * window.devicePixelRatio);
  const height = Math.round(canvas.clientHeight * window.devicePixelRatio);
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  const module = Math.min(width / (WIDTH + 2 * MARGIN), height / (HEIGHT + 2 * MARGIN));
  const left = (width - module * WIDTH) / 2;
  const top = (height - module * HEIGHT) / 2;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.fillStyle = "#fff";
  context.fillRect(0, 0, width, height);
  context.setTransform(module, 0, 0, module, left, top);
  for (const { box, isWhite } of patches(serverMs)) {
    context.fillStyle = isWhite ? "#fff" : "#000";
    context.fillRect(...box);
  }
}
