/**
 * Returns this page's offer with a request for stereo sound (`stereo`, RFC 7587, 6.1): without it
 * a browser decodes stereo to mono. An offer without Opus is returned as it is.
 * Pure.
 */
export function withStereo(offer: string): string {
  const type = /^a=rtpmap:(\d+) opus\//im.exec(offer)?.[1];
  if (type === undefined) return offer;
  const fmtp = new RegExp(`^a=fmtp:${type} (.*)$`, "m");
  const before = fmtp.exec(offer)?.[1];
  if (before === undefined) {
    return offer.replace(
      new RegExp(`^(a=rtpmap:${type} .*)$`, "m"),
      `$1\r\na=fmtp:${type} stereo=1`,
    );
  }
  const others = before.split(";").filter((one) => one !== "" && !/^\s*stereo=/i.test(one));
  return offer.replace(fmtp, `a=fmtp:${type} ${[...others, "stereo=1"].join(";")}`);
}
