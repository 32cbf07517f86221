import { useState } from "./context";
import { connectionWords } from "./words";

export function LinkStatus() {
  const { link, pageMs } = useState();
  // Only while a next attempt is awaited does this change with the time.
  const nowMs = link.value.is === "waiting" ? pageMs.value : 0;
  return (
    <p role="status" class={`link is-${link.value.is}`}>
      {connectionWords(link.value, nowMs)}
    </p>
  );
}
