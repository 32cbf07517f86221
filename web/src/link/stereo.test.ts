import { expect, it } from "vitest";
import { withStereo } from "./stereo";

const OFFER = [
  "v=0",
  "m=audio 9 UDP/TLS/RTP/SAVPF 111 63",
  "a=rtpmap:111 opus/48000/2",
  "a=fmtp:111 minptime=10;useinbandfec=1",
  "a=rtpmap:63 red/48000/2",
  "a=fmtp:63 111/111",
  "",
].join("\r\n");
const BEFORE = "a=fmtp:111 minptime=10;useinbandfec=1\r\n";

it("requests stereo for Opus only", () => {
  const after = "a=fmtp:111 minptime=10;useinbandfec=1;stereo=1\r\n";
  expect(withStereo(OFFER)).toBe(OFFER.replace(BEFORE, after));
});

it("requests it only once", () => {
  const offer = OFFER.replace("useinbandfec=1", "stereo=0;useinbandfec=1");
  expect(withStereo(offer)).toContain("a=fmtp:111 minptime=10;useinbandfec=1;stereo=1\r\n");
  expect(withStereo(withStereo(OFFER))).toBe(withStereo(OFFER));
});

it("adds the line if the offer has none", () => {
  expect(withStereo(OFFER.replace(BEFORE, ""))).toContain(
    "a=rtpmap:111 opus/48000/2\r\na=fmtp:111 stereo=1\r\n",
  );
});

it("leaves an offer without Opus as it is", () => {
  const pcmu = OFFER.replace("opus/48000/2", "PCMU/8000");
  expect(withStereo(pcmu)).toBe(pcmu);
});
