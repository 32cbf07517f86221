import type { VoiceEncoding } from "./encoding";

/**
 * Returns the server's answer with this encoding for the sound that the page sends: its packet
 * length (`ptime`, RFC 8866, 6.4), its bit rate, and no packets for silence (RFC 7587, 6.1).
 * Firefox takes a bit rate from nowhere else. An answer without Opus is returned as it is. Pure.
 */
export function withVoice(answer: string, { bitrateBps, packetMs }: VoiceEncoding): string {
  const sections = answer.split(/^(?=m=)/m);
  return sections.map((one) => (one.startsWith("m=audio ") ? shaped(one) : one)).join("");

  function shaped(section: string): string {
    const type = /^a=rtpmap:(\d+) opus\//im.exec(section)?.[1];
    if (type === undefined) return section;
    const fmtp = `a=fmtp:${type} `;
    const lines = section.trimEnd().split(/\r?\n/);
    const before = lines.find((line) => line.startsWith(fmtp))?.slice(fmtp.length) ?? "";
    const wanted = /^(minptime|ptime|maxptime|maxaveragebitrate|usedtx|useinbandfec)=/i;
    const parameters = [
      ...before.split(";").filter((one) => one !== "" && !wanted.test(one.trim())),
      "minptime=10",
      `maxaveragebitrate=${bitrateBps}`,
      "usedtx=1",
    ];
    const rest = lines.filter((line) => !line.startsWith(fmtp) && !/^a=(max)?ptime:/.test(line));
    const added = [`${fmtp}${parameters.join(";")}`, `a=ptime:${packetMs}`, "a=maxptime:60"];
    return `${[...rest, ...added].join("\r\n")}\r\n`;
  }
}
