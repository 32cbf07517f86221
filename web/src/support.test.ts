import { describe, expect, it } from "vitest";
import { lacksOf } from "./support";

class Peer {
  addTransceiver() {}
  createDataChannel() {}
}

class Channelless {
  addTransceiver() {}
}

/** A browser that has everything, but for what is said. */
function browser(but: Record<string, unknown> = {}) {
  const whole = { Array, AbortSignal, BroadcastChannel, crypto, RTCPeerConnection: Peer };
  return { ...whole, ...but } as unknown as typeof globalThis;
}

describe("what a browser lacks", () => {
  it("is nothing where everything is there", () => {
    expect(lacksOf(browser())).toBeNull();
  });

  it("is WebRTC where there is none, where it is switched off, and where it is of the old kind", () => {
    for (const none of [undefined, null, class {}, 0]) {
      const lacks = lacksOf(browser({ RTCPeerConnection: none }));
      expect(lacks).toEqual({ webrtc: true, channels: false, parts: [] });
    }
  });

  it("is the data channels where WebRTC has none", () => {
    const lacks = lacksOf(browser({ RTCPeerConnection: Channelless }));
    expect(lacks).toEqual({ webrtc: false, channels: true, parts: [] });
  });

  it("is each part that an older browser has not, by its name", () => {
    const old = { Array: class {}, AbortSignal: class {}, BroadcastChannel: undefined };
    expect(lacksOf(browser(old))?.parts).toEqual([
      "Array.prototype.findLast",
      "Array.prototype.toSorted",
      "AbortSignal.timeout",
      "BroadcastChannel",
    ]);
  });
});
