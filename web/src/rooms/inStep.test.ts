import { beforeEach, expect, it, vi } from "vitest";
import type { Receivers, ReporterOptions } from "../measure/report";
import type { Playout, Report } from "../messages";
import type { Facts } from "../state";
import { InStep } from "./inStep";
import { RenditionChoice } from "./rendition";

const made = vi.hoisted(() => ({ options: null as ReporterOptions | null, mapped: vi.fn() }));

vi.mock("../measure/report", () => ({
  Reporter: class {
    constructor(options: ReporterOptions) {
      made.options = options;
    }
    reset() {}
    mapped = made.mapped;
  },
}));

/** From NTP's epoch, 1900, to 1970. */
const NTP_MS = 2_208_988_800_000;

let isFirst: boolean;
let playouts: Playout[];
let facts: Facts[];
let rendition: RenditionChoice;
/** By how much the server's clock is ahead of the page's; null while unknown. */
let aheadMs: number | null;
let inStep: InStep;
let nowMs: number;

function receiver(source: object = {}) {
  const made = { jitterBufferTarget: null, getSynchronizationSources: () => [source] };
  return made as unknown as RTCRtpReceiver & { jitterBufferTarget: number | null };
}

beforeEach(() => {
  [isFirst, playouts, facts, nowMs] = [false, [], [], 0];
  aheadMs = null;
  vi.spyOn(performance, "now").mockImplementation(() => nowMs);
  made.mapped.mockClear();
  rendition = new RenditionChoice();
  inStep = new InStep({
    wants: () => ({ sound: true, picture: true }),
    isPictureFirst: () => isFirst,
    rendition,
    wall: {
      toServerMs: (pageMs) => aheadMs && pageMs + aheadMs,
      errorMs: () => aheadMs && 7,
    },
    onFacts: (now) => facts.push(now),
    onPlayout: (playout) => playouts.push(playout),
  });
});

/** Reports four times a second for this many seconds. */
function report(seconds: number, soundMs: number | null, pictureMs: number, frozenMs = () => 0) {
  for (let i = 0; i < 4 * seconds; i++) {
    nowMs += 250;
    const sound = soundMs === null ? null : { age_ms: soundMs, delay_ms: 60 };
    const picture = { age_ms: pictureMs, delay_ms: 20, frozen_ms: frozenMs() };
    made.options?.link.sendDrive({ sound, picture } as Report);
  }
}

function take(): { sound: ReturnType<typeof receiver>; picture: ReturnType<typeof receiver> } {
  const receivers = { sound: receiver(), picture: receiver() };
  inStep.setReceivers(receivers satisfies Receivers);
  nowMs += 1000;
  return receivers;
}

it("holds the picture back until its sound is heard, and leaves the sound to the browser", () => {
  const { sound, picture } = take();
  report(1, 180, 60);
  expect(picture.jitterBufferTarget).toBe(120);
  expect(sound.jitterBufferTarget).toBeNull();
  expect(playouts.at(-1)).toMatchObject({ policy: "audio-master", picture_target_ms: 120 });
});

it("holds another rendition back by as much from the start", () => {
  take();
  report(1, 180, 60);
  expect(take().picture.jitterBufferTarget).toBe(120);
});

it("holds nothing back if the picture has priority, or without sound", () => {
  const { picture } = take();
  report(1, 180, 60);
  report(1, null, 60);
  expect(picture.jitterBufferTarget).toBe(0);
  isFirst = true;
  report(10, 180, 60);
  expect(picture.jitterBufferTarget).toBe(0);
});

it("chooses the smaller rendition if pictures freeze", () => {
  take();
  report(5, 60, 60);
  let frozenMs = 0;
  report(5, 60, 60, () => {
    frozenMs += 100;
    return frozenMs;
  });
  expect(rendition.isSmall).toBe(true);
});

it("maps both streams by their packets' capture times", () => {
  const source = { rtpTimestamp: 7, captureTimestamp: 3e12 };
  inStep.setReceivers({ sound: receiver(source), picture: receiver(source) });
  inStep.readCaptures(0);
  expect(made.mapped.mock.calls.map(([clock]) => clock.kind)).toEqual(["audio", "video"]);
});

it("shows ages by the server's clock, but compares them relative to the fastest sample", () => {
  const source = { rtpTimestamp: 7, captureTimestamp: NTP_MS + 5000 };
  inStep.setReceivers({ sound: receiver(source), picture: receiver(source) });
  nowMs = 1000;
  inStep.readCaptures(nowMs);
  aheadMs = 4030;
  made.options?.onFacts({ pictureMs: 5, soundMs: 65, skewMs: 60 } as Facts);
  expect(facts).toEqual([{ pictureMs: 35, pictureErrorMs: 7, soundMs: 95, skewMs: 60 }]);
});

it("shows the skew, but no ages while the server's clock is unknown", () => {
  made.options?.onFacts({ pictureMs: 5, soundMs: 65, skewMs: 60 } as Facts);
  expect(facts).toEqual([{ pictureMs: null, pictureErrorMs: null, soundMs: null, skewMs: 60 }]);
});
