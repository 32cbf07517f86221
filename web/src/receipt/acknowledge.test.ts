import { beforeEach, expect, it, vi } from "vitest";
import type { Received } from "../messages";
import { Acknowledger } from "./acknowledge";

/** Replaces the browser's worker; the test sends its messages. */
class FakeWorker {
  static made: FakeWorker[] = [];
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onerror: (() => void) | null = null;

  constructor() {
    FakeWorker.made.push(this);
  }

  say(data: unknown): void {
    this.onmessage?.({ data });
  }
}

class FakeTransform {
  constructor(
    readonly worker: unknown,
    readonly kind: string,
  ) {}
}

let sent: Received[];
let acknowledger: Acknowledger;

beforeEach(() => {
  FakeWorker.made = [];
  vi.stubGlobal("Worker", FakeWorker);
  vi.stubGlobal("RTCRtpScriptTransform", FakeTransform);
  sent = [];
  acknowledger = new Acknowledger((received) => sent.push(received));
});

function worker(): FakeWorker {
  const newest = FakeWorker.made.at(-1);
  if (!newest) throw new Error("there is no worker");
  return newest;
}

/** The receivers of a new peer, as far as a transform needs them. */
function receivers() {
  const made = [{}, {}] as unknown as [RTCRtpReceiver, RTCRtpReceiver];
  acknowledger.watch(...made);
  return made as unknown as { transform?: FakeTransform }[];
}

it("is ready when its worker is, and watches both streams from then on", async () => {
  const started = acknowledger.start();
  expect(acknowledger.isReady).toBe(false);
  worker().say("ready");
  expect(await started).toBe(true);
  expect(receivers().map((one) => one.transform?.kind)).toEqual(["audio", "video"]);
});

it("acknowledges every picture, and the last sound packet of each unit", async () => {
  void acknowledger.start();
  worker().say("ready");
  receivers();
  acknowledger.units({ type: "units", last_rtp: 4000, length: 4000 });
  for (const rtp of [3200, 4000, 4800]) worker().say({ kind: "audio", rtp });
  worker().say({ kind: "video", rtp: 77 });
  expect(sent).toEqual([
    { type: "received", kind: "audio", rtp: 4000 },
    { type: "received", kind: "video", rtp: 77 },
  ]);
});

it("reports that the browser cannot, or that its worker does not start", async () => {
  const started = acknowledger.start();
  worker().onerror?.();
  expect(await started).toBe(false);
  expect(acknowledger.isReady).toBe(false);
  expect(receivers()[0]?.transform).toBeUndefined();
  Reflect.deleteProperty(globalThis, "RTCRtpScriptTransform");
  expect(await acknowledger.start()).toBe(false);
});
