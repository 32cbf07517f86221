import { type ReadonlySignal, signal } from "@preact/signals";

const IDLE_MS = 3000;
const SIGNS = ["pointermove", "pointerdown", "keydown"] as const;

/** Whether nobody has touched anything for 3 s; `end` stops watching. */
export function watchIdle(target: EventTarget): { isIdle: ReadonlySignal<boolean>; end(): void } {
  const isIdle = signal(true);
  const watching = new AbortController();
  let waiting: ReturnType<typeof setTimeout> | undefined;
  const touched = () => {
    isIdle.value = false;
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      isIdle.value = true;
    }, IDLE_MS);
  };
  for (const sign of SIGNS) target.addEventListener(sign, touched, { signal: watching.signal });
  return {
    isIdle,
    end() {
      watching.abort();
      clearTimeout(waiting);
    },
  };
}
