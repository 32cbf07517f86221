import { useState } from "./context";
import { connectionWords, toldWords } from "./pageWords";

/** The connection: a dot while all is well, words otherwise. */
export function LinkStatus() {
  const { link, pageMs, preferences } = useState();
  // Only these states change with time.
  const isTimed = link.value.is === "waiting" || link.value.is === "silent";
  const told = toldWords(link.value, preferences.value.picture);
  const nowMs = isTimed ? pageMs.value : 0;
  return (
    <>
      <p
        role="status"
        aria-live={isTimed || told ? "off" : "polite"}
        class={`link is-${link.value.is}`}
      >
        <span class={link.value.is === "connected" ? "visually-hidden" : ""}>
          {connectionWords(link.value, nowMs)}
        </span>
      </p>
      {/* A text that counts seconds would be read out every second. */}
      <span class="visually-hidden" aria-live="polite">
        {told}
      </span>
    </>
  );
}
