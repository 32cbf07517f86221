import { expect, it } from "vitest";
import { withVoice } from "./answer";
import { ENCODINGS, type VoiceEncoding } from "./encoding";

const ANSWER = [
  "v=0",
  "o=- 1 1 IN IP4 0.0.0.0",
  "m=audio 9 UDP/TLS/RTP/SAVPF 111 63",
  "a=sendrecv",
  "a=rtpmap:111 opus/48000/2",
  "a=fmtp:111 useinbandfec=1;stereo=0",
  "a=rtpmap:63 red/48000/2",
  "a=fmtp:63 111/111",
  "m=video 9 UDP/TLS/RTP/SAVPF 96",
  "a=rtpmap:96 VP8/90000",
  "",
].join("\r\n");

const THIN: VoiceEncoding = { bitrateBps: 6000, packetMs: 60 };

it("sets the encoding only in the section of the sound", () => {
  const [head, audio, video] = withVoice(ANSWER, THIN).split(/^(?=m=)/m);
  expect(head).toBe("v=0\r\no=- 1 1 IN IP4 0.0.0.0\r\n");
  expect(audio).toContain("a=ptime:60\r\n");
  expect(audio).toContain("a=fmtp:111 stereo=0;minptime=10;maxaveragebitrate=6000;usedtx=1\r\n");
  expect(audio).toContain("a=fmtp:63 111/111\r\n");
  expect(video).toBe("m=video 9 UDP/TLS/RTP/SAVPF 96\r\na=rtpmap:96 VP8/90000\r\n");
});

it("sets one encoding at a time", () => {
  const [best] = ENCODINGS;
  if (!best) throw new Error("there is no encoding");
  expect(withVoice(withVoice(ANSWER, best), THIN)).toBe(withVoice(ANSWER, THIN));
});

it("adds the line if the answer has none", () => {
  const without = ANSWER.replace("a=fmtp:111 useinbandfec=1;stereo=0\r\n", "");
  expect(withVoice(without, THIN)).toContain("a=fmtp:111 minptime=10;maxaveragebitrate=6000");
});

it("leaves an answer without Opus as it is", () => {
  const pcmu = ANSWER.replace("opus/48000/2", "PCMU/8000");
  expect(withVoice(pcmu, THIN)).toBe(pcmu);
});
