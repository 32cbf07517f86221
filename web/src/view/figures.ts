/** Measurements and streams in words and figures. */

import type { Breaks } from "../measure/breaks";
import type { Playout, Served } from "../messages";
import type { SoundPlayerState } from "../sound/soundPlayback";
import { said } from "../words/said";
import { type Code, figure, t } from "../words/words";

const UNKNOWN = "–";
const POLICY_NAMES: Readonly<Record<string, Code>> = {
  "audio-master": "watch.timing.smooth",
  "video-first": "watch.timing.immediate",
  thesis: "figures.as_in_thesis",
};

/** A figure in ms, or a dash without a measurement. */
export function msWords(ms: number | null): string {
  if (ms === null) return UNKNOWN;
  return ms < 10_000 ? `${figure(Math.round(ms))} ms` : `${figure(Math.round(ms / 1000))} s`;
}

/** An age and its largest possible error, rounded up: `46 ms ± 3`. */
export function ageWords(ms: number | null, errorMs: number | null): string {
  return ms === null || errorMs === null
    ? msWords(ms)
    : `${msWords(ms)} ± ${figure(Math.ceil(errorMs))}`;
}

/** How much later than the picture the sound plays. */
export function skewWords(skewMs: number | null): string {
  if (skewMs === null) return UNKNOWN;
  const ms = Math.round(skewMs);
  if (ms === 0) return t("figures.in_step");
  const apart = { ms: figure(Math.abs(ms)) };
  return ms > 0 ? t("figures.sound_later", apart) : t("figures.sound_earlier", apart);
}

/** The interruptions of the last minute: `2, longest 120 ms`. */
export function breakWords(breaks: Breaks | null): string {
  if (!breaks) return UNKNOWN;
  const { count, longestMs } = breaks;
  if (count === 0) return t("figures.no_breaks");
  return t("figures.breaks", { count: figure(count), longest: msWords(longestMs) });
}

/** The playback policy, by its name in `Timing`. */
export function policyWords(policy: string | undefined): string {
  const name = POLICY_NAMES[policy ?? ""];
  return name ? t(name) : UNKNOWN;
}

/** `640x480`, or `640x480 at 500 kbit/s`, as people write it. */
export function sizeWords(name: string): string {
  const [size = "", rate] = name.replace("x", " × ").split(" at ");
  return rate === undefined ? size : t("figures.size_at", { size, rate });
}

export function sentPictureWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  if (served.rendition === null) return t("figures.nothing_sent");
  const { layers, layers_made } = served;
  const isLayered = layers !== null && layers_made !== null;
  return [
    sizeWords(served.rendition),
    t("figures.fps", { fps: figure(Number(served.picture_hz.toFixed(1))) }),
    ...(isLayered ? [t("figures.layers", { layers, made: layers_made })] : []),
  ].join(", ");
}

export function sentSoundWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  if (served.sound_mu_ms === null) return t("figures.nothing_sent");
  const { sound_mu_ms, sound_bps, sound_channels, redundancy } = served;
  const rate = rateWords(sound_bps);
  return [
    t("figures.packets", { ms: figure(sound_mu_ms) }),
    sound_channels > 1 ? t("figures.stereo", { rate }) : rate,
    ...(redundancy > 0 ? [t("figures.repeats", { count: redundancy })] : []),
  ].join(", ");
}

/** The link's estimated rate, and how much of it is used. */
export function linkWords(served: Served | null): string {
  if (!served) return UNKNOWN;
  const { link_bps, used_bps, queue_ms } = served;
  return t("figures.link", {
    rate: rateWords(link_bps),
    used: rateWords(used_bps),
    queue: msWords(queue_ms),
  });
}

/** Why no more is sent, and why it plays with this delay, in the server's sentences. */
export function reasons(
  playout: Playout | null,
  served: Served | null,
  player: SoundPlayerState,
): string[] {
  return [...new Set([said(served?.reason), said(playout?.reason), player.why])].flatMap(
    (one) => one || [],
  );
}

function rateWords(bps: number): string {
  return bps < 1e6
    ? `${figure(Math.round(bps / 1000))} kbit/s`
    : `${figure(Number((bps / 1e6).toFixed(1)))} Mbit/s`;
}
