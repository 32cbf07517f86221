import type { Playout } from "./messages";

/** The largest `jitterBufferTarget` (webrtc-extensions 4.2); a larger one throws. */
const MAX_TARGET_MS = 4000;

interface Buffered {
  jitterBufferTarget?: number | null;
}

/** Sets the targets of the two jitter buffers, if the browser supports it. */
export function applyPlayout(
  playout: Playout,
  sound: RTCRtpReceiver | null,
  picture: RTCRtpReceiver | null,
): void {
  if (sound) aim(sound, playout.sound_target_ms);
  if (picture) aim(picture, playout.picture_target_ms);
}

function aim(receiver: RTCRtpReceiver & Buffered, targetMs: number | null): void {
  if (!("jitterBufferTarget" in receiver)) return;
  receiver.jitterBufferTarget =
    targetMs === null ? null : Math.min(Math.max(targetMs, 0), MAX_TARGET_MS);
}
