import { expect, it } from "vitest";
import { sample } from "../testing/samples";
import { History, type Sample } from "./history";
import { type Now, why } from "./why";

const NOW: Now = {
  nowMs: 60_000,
  isConnected: true,
  isHidden: false,
  isBlanked: false,
  wantsPicture: true,
  driveReason: null,
};

/** A link on which nothing is slow. */
const FINE = {
  pictureMs: 60,
  soundMs: 70,
  skewMs: 10,
  jitterMs: 2,
  bufferMs: 30,
  roundTripMs: 20,
  heldMs: 10,
  linkBps: 4_000_000,
  usedBps: 600_000,
  queueMs: 3,
  widthPx: 640,
  askedPx: 640,
  sentHz: 30,
  arrivedHz: 30,
  shownHz: 29,
};

/** The answer for ten seconds of this sample. */
function about(more: Partial<Sample> = {}, now: Partial<Now> = {}) {
  const history = new History();
  for (let i = 10; i > 0; i--) history.add(sample(60_000 - i * 1000, { ...FINE, ...more }));
  return why(history, { ...NOW, ...now });
}

it("says that nothing is slow if nothing is", () => {
  expect(about()).toEqual({ code: "stats.why.nothing", values: {} });
});

it.each<[string, Partial<Sample>, Partial<Now>, object]>([
  ["unconnected", {}, { isConnected: false }, {}],
  ["unmeasured", {}, { nowMs: 90_000 }, {}],
  ["blanked", {}, { isBlanked: true }, {}],
  ["hidden", { shownHz: 0 }, { isHidden: true }, {}],
  ["robot", {}, { driveReason: "Slow." }, { reason: "Slow." }],
  ["pictureless", { widthPx: 0, sentHz: 0, linkBps: 40_400 }, {}, { kbps: 40 }],
  ["queue", { queueMs: 240.4 }, {}, { ms: 240 }],
  ["small", { widthPx: 320, linkBps: 180_000 }, {}, { kbps: 180, px: 320 }],
  [
    "starved",
    { sentHz: 7.5, arrivedHz: 7.5, shownHz: 7, linkBps: 500_000, usedBps: 450_000 },
    {},
    { kbps: 500, hz: 8 },
  ],
  ["browser", { shownHz: 12 }, {}, { shown: 12, sent: 30 }],
  ["lossy", { arrivedHz: 12, shownHz: 12 }, {}, { arrived: 12, sent: 30 }],
  ["slow_camera", { sentHz: 5, arrivedHz: 5, shownHz: 5 }, {}, { hz: 5 }],
  ["distance", { pictureMs: 260, roundTripMs: 440 }, {}, { own: 220, all: 260 }],
  ["distance", { pictureMs: null, soundMs: 260, roundTripMs: 440 }, {}, { own: 220, all: 260 }],
  ["uneven", { soundMs: 200, jitterMs: 45, bufferMs: 120 }, {}, { jitter: 45, ms: 120 }],
  ["held", { pictureMs: 200, heldMs: 120 }, {}, { ms: 120 }],
])("explains by %s", (name, more, now, values) => {
  expect(about(more, now)).toEqual({ code: `stats.why.${name}`, values });
});

it("names the cause rather than its consequence", () => {
  const thin = { widthPx: 160, linkBps: 60_000, queueMs: 400, jitterMs: 60, shownHz: 3 };
  expect(about(thin).code).toBe("stats.why.queue");
  expect(about({ ...thin, queueMs: 0 }).code).toBe("stats.why.small");
  expect(about(thin, { isConnected: false }).code).toBe("stats.why.unconnected");
});

it("does not call an unwanted picture slow", () => {
  const off = { widthPx: 0, askedPx: 0, sentHz: 0, arrivedHz: null, shownHz: null };
  const wishes = { wantsPicture: false };
  expect(about({ ...off, pictureMs: null }, wishes).code).toBe("stats.why.nothing");
});

it("ignores a single bad moment", () => {
  const history = new History();
  for (let i = 10; i > 1; i--) history.add(sample(60_000 - i * 1000, FINE));
  history.add(sample(59_000, { ...FINE, queueMs: 2000, shownHz: 0 }));
  expect(why(history, NOW).code).toBe("stats.why.nothing");
});

it("claims nothing about figures that this browser does not report", () => {
  const history = new History();
  history.add(sample(59_000));
  expect(why(history, NOW).code).toBe("stats.why.nothing");
  expect(why(new History(), NOW).code).toBe("stats.why.unmeasured");
});
