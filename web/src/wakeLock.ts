/** Keeps the screen on while the user drives, waits or watches, where the browser allows it. */

import { computed, effect, type ReadonlySignal } from "@preact/signals";
import type { State } from "./state";
import { within } from "./within";

interface Screen {
  document: Pick<Document, "visibilityState" | "addEventListener" | "removeEventListener">;
  wakeLock: Pick<WakeLock, "request"> | undefined;
}

function ownScreen(): Screen {
  return { document, wakeLock: navigator.wakeLock };
}

/** Whether the user needs the screen: they drive, wait, or have a picture. */
export function needsScreen(state: State): ReadonlySignal<boolean> {
  return computed(() => {
    if (!state.isConnected.value || state.ended.value) return false;
    const role = state.me.value?.role;
    if (role === "operator" || role === "queued") return true;
    return state.preferences.value.picture && !state.isBlanked.value;
  });
}

/**
 * Holds a wake lock while `isNeeded`, and takes it again after the browser released it, as it does
 * when the page is hidden. Without the API, or where the browser refuses (on low battery), the
 * screen silently sleeps as usual. Returns a function that ends it.
 */
export function keepAwake(isNeeded: ReadonlySignal<boolean>, screen = ownScreen()): () => void {
  const { document, wakeLock } = screen;
  if (!wakeLock) return () => {};
  let held: WakeLockSentinel | null = null;
  let isAsking = false;

  const hold = (given: WakeLockSentinel) => {
    void held?.release().catch(() => {});
    held = given;
    given.addEventListener("release", () => {
      if (held === given) held = null;
    });
    void look(); // it may not be needed any more
  };
  const look = async () => {
    const isWanted = isNeeded.peek() && document.visibilityState === "visible";
    if (isWanted && !held && !isAsking) {
      isAsking = true;
      const given = wakeLock.request("screen").then(hold);
      // Refused or unanswered; requested again when the page is next shown.
      await within("wakeLock.request", given).catch(() => {});
      isAsking = false;
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
