import { expect, it } from "vitest";
import { applyPlayout } from "./jitterBufferTargets";
import { says } from "./words/said";

type Receiver = RTCRtpReceiver & { jitterBufferTarget?: number | null };

function receiver(has = true): Receiver {
  return (has ? { jitterBufferTarget: null } : {}) as Receiver;
}

function playout(sound_target_ms: number | null, picture_target_ms: number | null) {
  return {
    type: "playout",
    policy: "p",
    player: "browser",
    reason: says("r"),
    sound_target_ms,
    picture_target_ms,
  } as const;
}

it("gives each buffer its own target, and null back to the browser", () => {
  const [sound, picture] = [receiver(), receiver()];
  applyPlayout(playout(200, 180.5), sound, picture);
  expect([sound.jitterBufferTarget, picture.jitterBufferTarget]).toEqual([200, 180.5]);
  applyPlayout(playout(null, 0), sound, picture);
  expect([sound.jitterBufferTarget, picture.jitterBufferTarget]).toEqual([null, 0]);
});

it("leaves the picture's buffer to the browser while it sets the sound's", () => {
  const [sound, picture] = [receiver(), receiver()];
  applyPlayout(playout(60, null), sound, picture);
  expect([sound.jitterBufferTarget, picture.jitterBufferTarget]).toEqual([60, null]);
});

it("stays within what a browser accepts", () => {
  const [sound, picture] = [receiver(), receiver()];
  applyPlayout(playout(9000, -5), sound, picture);
  expect([sound.jitterBufferTarget, picture.jitterBufferTarget]).toEqual([4000, 0]);
});

it("does nothing in a browser without such a target", () => {
  const old = receiver(false);
  applyPlayout(playout(200, 200), old, receiver());
  expect(old).toEqual({});
});
