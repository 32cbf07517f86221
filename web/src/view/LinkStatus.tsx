import { useState } from "./context";
import { connectionWords } from "./words";

export function LinkStatus() {
  const { link, pageMs } = useState();
  // Only these states change with time.
  const isTimed = link.value.is === "waiting" || link.value.is === "silent";
  const nowMs = isTimed ? pageMs.value : 0;
  return (
    <p role="status" class={`link is-${link.value.is}`}>
      {connectionWords(link.value, nowMs)}
    </p>
  );
}
