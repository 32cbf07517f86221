/** Changes of network that the browser reports. */

/** The Network Information API, which only some browsers have; `type` only on phones. */
interface Connection extends EventTarget {
  readonly type?: string;
}

/** Calls `changed` when the device has a network again, or another one. */
export function watchNetwork(changed: () => void, signal: AbortSignal): void {
  window.addEventListener("online", changed, { signal });
  const connection = (navigator as { connection?: Connection }).connection;
  let type = connection?.type;
  // The event also fires on every new estimate of the speed.
  const look = () => {
    if (connection?.type === type) return;
    type = connection?.type;
    if (type !== "none") changed();
  };
  connection?.addEventListener("change", look, { signal });
}
