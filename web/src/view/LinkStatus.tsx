import { useState } from "./context";
import { connectionWords } from "./words";

/** The connection: a dot while all is well, words as soon as it is not. */
export function LinkStatus() {
  const { link, pageMs } = useState();
  // Only these states change with time.
  const isTimed = link.value.is === "waiting" || link.value.is === "silent";
  const nowMs = isTimed ? pageMs.value : 0;
  return (
    <p role="status" class={`link is-${link.value.is}`}>
      <span class={link.value.is === "connected" ? "visually-hidden" : ""}>
        {connectionWords(link.value, nowMs)}
      </span>
    </p>
  );
}
