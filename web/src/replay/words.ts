/** The sentences of the tape's page. Pure. */

import type { Commanded, Reported, Steered, TapePart, Watched } from "../messages";
import { words } from "./timeline";

/** Names of reasons that are no sentence by themselves. */
const REASONS: Record<string, string> = { pressed: "Stop is pressed" };
const KEPT = { host: "kept", operator: "kept by an operator", fault: "a fault" };

/** Returns what says a part in the list: when it began, its size, and why it is kept. */
export function partWords(locale?: string): (part: TapePart) => string {
  // Making this takes longer than using it, and a week has ten thousand parts.
  const time = new Intl.DateTimeFormat(locale, { dateStyle: "medium", timeStyle: "medium" });
  return (part) => {
    const size = `${(part.size_bytes / 1e6).toFixed(1)} MB`;
    const kept = part.kept ? [KEPT[part.kept]] : [];
    return [time.format(part.began_wall_ms), size, ...kept].join(", ");
  };
}

/** A time within a part: `1:05.3`. */
export function clockWords(ms: number): string {
  const tenths = Math.max(0, Math.floor(ms / 100));
  const seconds = Math.floor(tenths / 10) % 60;
  return `${Math.floor(tenths / 600)}:${String(seconds).padStart(2, "0")}.${tenths % 10}`;
}

/** What the operator's hands do. */
export function commandWords(command: Commanded | null): string {
  if (!command) return "no commands arrive";
  if (!command.held) return "nothing is held";
  const { linear, angular } = command;
  const along = linear > 0 ? "forward" : linear < 0 ? "back" : null;
  const around = angular > 0 ? "left" : angular < 0 ? "right" : null;
  const held = [
    ...(along ? [`${along} ${percent(linear)}`] : []),
    ...(around ? [`${around} ${percent(angular)}`] : []),
    ...Object.keys(command.axes),
  ];
  return [held.join(", ") || "held, but not moved", command.speed].join("; ");
}

/** What came of it: the robot's set-point, and what holds or slows it. */
export function steeredWords(steered: Steered | null): string {
  if (!steered) return "unknown";
  const { linear_mps, angular_rps, reason, limit } = steered;
  const motion =
    linear_mps === 0 && angular_rps === 0
      ? "stands"
      : `${linear_mps.toFixed(2)} m/s, ${angular_rps.toFixed(2)} rad/s`;
  const why = reason ?? limit;
  return why ? `${motion} (${REASONS[why] ?? words(why)})` : motion;
}

/** What the robot says of itself. */
export function reportedWords(reported: Reported | null): string {
  if (!reported) return "unknown";
  if (!reported.connected) return "not connected";
  const said = [
    ...(reported.problem ? [reported.problem] : []),
    ...(reported.moving === null ? [] : [reported.moving ? "its wheels turn" : "its wheels stand"]),
    ...(reported.bumpers ? ["a bumper is pressed"] : []),
    ...(reported.battery_v === null ? [] : [`${reported.battery_v.toFixed(1)} V`]),
  ];
  return said.join(", ") || "nothing";
}

/** How the operator had it. */
export function watchedWords(watched: Watched | null): string {
  if (!watched) return "unknown";
  const { picture_ms, sound_ms, round_trip_ms, rendition, why } = watched;
  return [
    `picture ${age(picture_ms)}`,
    `sound ${age(sound_ms)}`,
    `there and back ${age(round_trip_ms)}`,
    ...(rendition ? [rendition] : ["no picture sent"]),
    ...(why ? [why] : []),
  ].join("; ");
}

function age(ms: number | null): string {
  return ms === null ? "unknown" : `${Math.round(ms)} ms`;
}

function percent(share: number): string {
  return `${Math.round(Math.abs(share) * 100)} %`;
}
