/** Whether this browser can show the page at all, judged by its features, never by its name. */

/**
 * What is missing: WebRTC, for picture and sound; its data channels, to drive by; or parts of
 * JavaScript and the browser that the page relies on.
 */
export interface Lacks {
  webrtc: boolean;
  channels: boolean;
  /** The missing parts' names, as a developer writes them. */
  parts: readonly string[];
}

type Scope = Partial<typeof globalThis>;

/** What the page relies on, as paths from the global object. */
const PARTS = [
  "Array.prototype.findLast",
  "Array.prototype.toSorted",
  "AbortSignal.timeout",
  "BroadcastChannel",
  "crypto.getRandomValues",
] as const;

/** What this browser lacks; null if nothing. */
export function lacksOf(scope: Scope = globalThis): Lacks | null {
  const has = (name: string) => isThere(scope, name);
  const webrtc = !has("RTCPeerConnection.prototype.addTransceiver");
  const lacks = {
    webrtc,
    channels: !webrtc && !has("RTCPeerConnection.prototype.createDataChannel"),
    parts: PARTS.filter((name) => !has(name)),
  };
  return lacks.webrtc || lacks.channels || lacks.parts.length > 0 ? lacks : null;
}

function isThere(scope: Scope, name: string): boolean {
  let found: unknown = scope;
  for (const part of name.split(".")) {
    if (found === null || (typeof found !== "object" && typeof found !== "function")) return false;
    if (!(part in found)) return false;
    found = Reflect.get(found, part);
  }
  // Some browsers keep the name of a feature that is switched off.
  return found !== undefined && found !== null;
}
