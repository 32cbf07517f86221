import { expect, it } from "vitest";
import { playout, served } from "../testing/messages";
import { says } from "../words/said";
import {
  ageWords,
  breakWords,
  linkWords,
  msWords,
  policyWords,
  reasons,
  sentPictureWords,
  sentSoundWords,
  sizeWords,
  skewWords,
} from "./figures";

it("writes a dash for unknown values", () => {
  expect(msWords(null)).toBe("–");
  expect(ageWords(null, 3)).toBe("–");
  expect(skewWords(null)).toBe("–");
  expect(breakWords(null)).toBe("–");
  expect([sentPictureWords(null), sentSoundWords(null), linkWords(null)]).toEqual(["–", "–", "–"]);
  expect(reasons(null, null, BROWSER)).toEqual([]);
});

it("names the playback policy as the choice does, never by a code", () => {
  expect(policyWords("audio-master")).toBe("Smooth");
  expect(policyWords("video-first")).toBe("Immediate");
  expect(policyWords("thesis")).toBe("as in the thesis");
  expect([policyWords(undefined), policyWords("newer")]).toEqual(["–", "–"]);
});

it("writes times, and an age's error rounded up", () => {
  expect(msWords(34.4)).toBe("34 ms");
  expect(msWords(12_300)).toBe("12 s");
  expect(ageWords(46.2, 2.1)).toBe("46 ms ± 3");
  expect(ageWords(46.2, null)).toBe("46 ms");
});

it("writes whether picture or sound comes first", () => {
  expect(skewWords(46)).toBe("sound 46 ms later");
  expect(skewWords(-4)).toBe("sound 4 ms earlier");
  expect(skewWords(0.2)).toBe("in step");
});

it("writes the number of breaks", () => {
  expect(breakWords({ count: 0, longestMs: 0 })).toBe("none");
  expect(breakWords({ count: 2, longestMs: 119.6 })).toBe("2, longest 120 ms");
});

it("writes what is sent", () => {
  expect(sizeWords("640x480")).toBe("640 × 480");
  expect(sentPictureWords(served({ picture_hz: 7.5, layers: 2, layers_made: 3 }))).toBe(
    "640 × 480 at 500 kbit/s, 7.5 fps, 2 of 3 layers",
  );
  expect(sentPictureWords(served({ layers: null }))).toBe("640 × 480 at 500 kbit/s, 30 fps");
  expect(sentPictureWords(served({ rendition: null }))).toBe("none");
  expect(sentSoundWords(served({ sound_mu_ms: 60, redundancy: 1 }))).toBe(
    "60 ms packets, 32 kbit/s, each repeats the last 1",
  );
  expect(sentSoundWords(served({ sound_mu_ms: null }))).toBe("none");
  expect(sentSoundWords(served({ sound_bps: 56_000, sound_channels: 2 }))).toBe(
    "20 ms packets, 56 kbit/s stereo",
  );
  expect(linkWords(served())).toBe("2.4 Mbit/s, 590 kbit/s used, 4 ms queue");
});

const BROWSER = { by: "browser", why: null } as const;

it("says why the built-in player does not play", () => {
  expect(reasons(null, null, { by: "browser", why: "No HTTPS." })).toEqual(["No HTTPS."]);
});

it("gives every reason once", () => {
  const [one, two] = [playout({ reason: says("A.") }), served({ reason: says("B.") })];
  expect(reasons(one, two, BROWSER)).toEqual(["B.", "A."]);
  expect(reasons(playout({ reason: says("B.") }), two, BROWSER)).toEqual(["B."]);
  expect(reasons(playout({ reason: says("") }), null, BROWSER)).toEqual([]);
});
