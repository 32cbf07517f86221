/** Measurements and streams in words and figures. */

import type { Breaks } from "../measure/breaks";
import type { Playout, Served } from "../messages";
import type { SoundPlayerState } from "../sound/soundPlayback";

const UNKNOWN = "–";

/** A figure in ms, or a dash without a measurement. */
export function msWords(ms: number | null): string {
  if (ms === null) return UNKNOWN;
  return ms < 10_000 ? `${Math.round(ms)} ms` : `${Math.round(ms / 1000)} s`;
}

/** An age and its largest possible error, rounded up: `46 ms ± 3`. */
export function ageWords(ms: number | null, errorMs: number | null): string {
  return ms === null || errorMs === null ? msWords(ms) : `${msWords(ms)} ± ${Math.ceil(errorMs)}`;
}

/** How much later than the picture the sound plays. */
export function skewWords(skewMs: number | null): string {
  if (skewMs === null) return UNKNOWN;
  const ms = Math.round(skewMs);
  if (ms === 0) return "in step";
  return `sound ${Math.abs(ms)} ms ${ms > 0 ? "later" : "earlier"}`;
}

/** The interruptions of the last minute: `2, longest 120 ms`. */
export function breakWords(breaks: Breaks | null): string {
  if (!breaks) return UNKNOWN;
  return breaks.count === 0 ? "none" : `${breaks.count}, longest ${msWords(breaks.longestMs)}`;
}

/** `640x480` as people write it. */
export function sizeWords(size: string): string {
  return size.replace("x", " × ");
}

export function sentPictureWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  if (served.rendition === null) return "none";
  const { layers, layers_made } = served;
  const isLayered = layers !== null && layers_made !== null;
  return [
    sizeWords(served.rendition),
    `${Number(served.picture_hz.toFixed(1))} fps`,
    ...(isLayered ? [`${layers} of ${layers_made} layers`] : []),
  ].join(", ");
}

export function sentSoundWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  if (served.sound_mu_ms === null) return "none";
  const { sound_mu_ms, sound_bps, sound_channels, redundancy } = served;
  const channels = sound_channels > 1 ? " stereo" : "";
  const again = redundancy > 0 ? `, each repeats the last ${redundancy}` : "";
  return `${sound_mu_ms} ms packets, ${rateWords(sound_bps)}${channels}${again}`;
}

/** The link's estimated rate, and how much of it is used. */
export function linkWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  const { link_bps, used_bps, queue_ms } = served;
  return `${rateWords(link_bps)}, ${rateWords(used_bps)} used, ${msWords(queue_ms)} queue`;
}

/** Why no more is sent, and why it plays with this delay: sentences from the server. */
export function reasons(
  playout: Playout | null,
  served: Served | null,
  player: SoundPlayerState,
): string[] {
  return [...new Set([served?.reason, playout?.reason, player.why])].flatMap((one) => one || []);
}

function rateWords(bps: number): string {
  return bps < 1e6
    ? `${Math.round(bps / 1000)} kbit/s`
    : `${Number((bps / 1e6).toFixed(1))} Mbit/s`;
}
