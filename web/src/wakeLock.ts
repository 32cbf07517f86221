/** Keeps the screen on while somebody drives, waits or watches, where the browser lets a page. */

import { computed, effect, type ReadonlySignal } from "@preact/signals";
import type { State } from "./state";

interface Screen {
  document: Pick<Document, "visibilityState" | "addEventListener" | "removeEventListener">;
  wakeLock: Pick<WakeLock, "request"> | undefined;
}

function ownScreen(): Screen {
  return { document, wakeLock: navigator.wakeLock };
}

/** Whether somebody needs to see: who drives or waits, and who has a picture. */
export function needsScreen(state: State): ReadonlySignal<boolean> {
  return computed(() => {
    if (!state.isConnected.value || state.ended.value) return false;
    const role = state.me.value?.role;
    if (role === "operator" || role === "queued") return true;
    return state.preferences.value.picture && !state.isBlanked.value;
  });
}

/**
 * Holds a lock while `isNeeded`, and again after the browser has taken it, as it does when the page
 * is hidden. Where there is none, or the browser refuses (on low battery), nothing is said: the
 * screen then sleeps as it always does. Returns a function that ends it.
 */
export function keepAwake(isNeeded: ReadonlySignal<boolean>, screen = ownScreen()): () => void {
  const { document, wakeLock } = screen;
  if (!wakeLock) return () => {};
  let held: WakeLockSentinel | null = null;
  let isAsking = false;

  const look = async () => {
    const isWanted = isNeeded.peek() && document.visibilityState === "visible";
    if (isWanted && !held && !isAsking) {
      isAsking = true;
      try {
        const given = await wakeLock.request("screen");
        held = given;
        given.addEventListener("release", () => {
          if (held === given) held = null;
        });
      } catch {
        // Refused; asked again when the page is shown the next time.
        return;
      } finally {
        isAsking = false;
      }
      void look(); // it may not be needed any more
    } else if (!isWanted && held) {
      const over = held;
      held = null;
      await over.release().catch(() => {});
    }
  };

  const onVisible = () => void look();
  document.addEventListener("visibilitychange", onVisible);
  const unwatch = effect(() => {
    void isNeeded.value;
    void look();
  });
  return () => {
    unwatch();
    document.removeEventListener("visibilitychange", onVisible);
    void held?.release().catch(() => {});
    held = null;
  };
}
