// @vitest-environment dom
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { testSession } from "../testing/session";
import { enterHeadset, inHeadset } from "./enter";

const upload = vi.fn();
const clear = vi.fn();
const known = { texImage2D: upload, clear, isContextLost: () => isLost };
let isLost: boolean;
let canvas: EventTarget;
let session: XRSession;
let next: XRFrameRequestCallback;
let video: HTMLVideoElement;

/** Answers whatever drawing asks of it. */
function drawing(own: Record<PropertyKey, unknown>): unknown {
  const rest = () => ({ width: 10 });
  return new Proxy(own, { get: (_, name) => own[name] ?? rest });
}

function frames(count: number): void {
  const frame = { getViewerPose: () => ({ views: [] }) } as unknown as XRFrame;
  for (let at = 0; at < count; at++) next(0, frame);
}

const uploads = () => upload.mock.calls.filter((call) => call.at(-1) === video).length;

beforeEach(async () => {
  isLost = false;
  upload.mockClear();
  clear.mockClear();
  canvas = new EventTarget();
  vi.stubGlobal("XRWebGLLayer", class {});
  const context = (kind: string) => drawing(kind === "webgl" ? { ...known, canvas } : {});
  vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockImplementation(context as never);
  session = Object.assign(new EventTarget(), {
    visibilityState: "visible",
    inputSources: [],
    requestReferenceSpace: async () => ({}),
    updateRenderState: vi.fn(),
    requestAnimationFrame: (callback: XRFrameRequestCallback) => {
      next = callback;
    },
    end: vi.fn(async () => void session.dispatchEvent(new Event("end"))),
  }) as unknown as XRSession;
  video = document.createElement("video");
  for (const side of ["videoWidth", "videoHeight"]) {
    Object.defineProperty(video, side, { value: 480 });
  }
});

afterEach(() => {
  session.dispatchEvent(new Event("end"));
  Reflect.deleteProperty(HTMLVideoElement.prototype, "requestVideoFrameCallback");
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

async function enters(): Promise<void> {
  const page = { ...testSession(), shownPicture: () => video };
  await enterHeadset(page, { requestSession: async () => session } as unknown as XRSystem);
}

it("is not in a session that ended before it could begin", async () => {
  session.requestReferenceSpace = async () => {
    session.dispatchEvent(new Event("end"));
    return {} as XRReferenceSpace;
  };
  await expect(enters()).rejects.toThrow("ended");
  expect(inHeadset.value).toBeNull();
});

describe("the picture", () => {
  it("is what the browser presents, frame by frame", async () => {
    let presented: (() => void) | undefined;
    const request = vi.fn((callback: VideoFrameRequestCallback) => {
      presented = () => callback(0, {} as VideoFrameCallbackMetadata);
      return 1;
    });
    HTMLVideoElement.prototype.requestVideoFrameCallback = request;
    await enters();
    frames(3);
    expect(uploads()).toBe(1);
    presented?.();
    frames(3);
    expect(uploads()).toBe(2);
  });

  it("never stands still where the browser does not tell", async () => {
    await enters();
    frames(3);
    expect(uploads()).toBe(3);
  });
});

it("does not count as drawn, and ends the session, once WebGL is lost", async () => {
  await enters();
  frames(1);
  expect(clear).toHaveBeenCalledTimes(1);
  isLost = true;
  frames(1);
  expect(clear).toHaveBeenCalledTimes(1);
  expect(inHeadset.value).toBe(session);
  canvas.dispatchEvent(new Event("webglcontextlost"));
  expect(session.end).toHaveBeenCalledTimes(1);
  expect(inHeadset.value).toBeNull();
});
