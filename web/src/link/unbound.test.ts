import { beforeEach, expect, it, vi } from "vitest";
import { makePeer } from "./unbound";

class TopPeer {}
class FramePeer {
  constructor(readonly configuration: RTCConfiguration) {}
}
class FakeFrame {
  allow = "";
  hidden = false;
  isConnected = false;
  contentWindow = { RTCPeerConnection: FramePeer };
}

const WISH: RTCConfiguration = { bundlePolicy: "max-bundle" };
let frames: FakeFrame[];
let page: { documentElement: { dataset: { view?: string } } };

beforeEach(() => {
  frames = [];
  const append = (frame: FakeFrame) => {
    frame.isConnected = true;
    frames.push(frame);
  };
  const documentElement = { dataset: {} };
  page = Object.assign(
    { documentElement },
    { createElement: () => new FakeFrame(), body: { append } },
  );
  vi.stubGlobal("RTCPeerConnection", TopPeer);
  vi.stubGlobal("document", page);
});

it("creates peers in one permanent frame that may not use the microphone", () => {
  Object.assign(page, { featurePolicy: {} });
  const peer = makePeer(WISH);
  expect(peer).toBeInstanceOf(FramePeer);
  expect(peer).toMatchObject({ configuration: WISH });
  expect(frames).toMatchObject([{ hidden: true, allow: "microphone 'none'; camera 'none'" }]);
  expect(makePeer(WISH)).toBeInstanceOf(FramePeer);
  expect(frames).toHaveLength(1);
});

it("creates them directly in another site's frame, and in other browsers", () => {
  expect(makePeer(WISH)).toBeInstanceOf(TopPeer);
  Object.assign(page, { featurePolicy: {} });
  page.documentElement.dataset.view = "embed";
  expect(makePeer(WISH)).toBeInstanceOf(TopPeer);
  expect(frames).toEqual([]);
});
