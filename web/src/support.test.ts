import { describe, expect, it } from "vitest";
import { lacksOf } from "./support";

class Peer {
  addTransceiver() {}
  createDataChannel() {}
}

class Channelless {
  addTransceiver() {}
}

/** A browser that has everything except for these changes. */
function browser(but: Record<string, unknown> = {}) {
  const whole = { Array, AbortSignal, BroadcastChannel, crypto, RTCPeerConnection: Peer };
  return { ...whole, ...but } as unknown as typeof globalThis;
}

describe("what a browser lacks", () => {
  it("is nothing if everything is there", () => {
    expect(lacksOf(browser())).toBeNull();
  });

  it("is WebRTC if it is missing, switched off, or of the old kind", () => {
    for (const none of [undefined, null, class {}, 0]) {
      const lacks = lacksOf(browser({ RTCPeerConnection: none }));
      expect(lacks).toEqual({ webrtc: true, channels: false, parts: [] });
    }
  });

  it("is the data channels if WebRTC has none", () => {
    const lacks = lacksOf(browser({ RTCPeerConnection: Channelless }));
    expect(lacks).toEqual({ webrtc: false, channels: true, parts: [] });
  });

  it("is each part that an older browser lacks, by its name", () => {
    const old = { Array: class {}, AbortSignal: class {}, BroadcastChannel: undefined };
    expect(lacksOf(browser(old))?.parts).toEqual([
      "Array.prototype.findLast",
      "Array.prototype.toSorted",
      "AbortSignal.timeout",
      "BroadcastChannel",
    ]);
  });
});
