/** The sentences of the replay page. */

import type { Commanded, Reported, Steered, TapePart, Watched } from "../messages";
import { msWords, sizeWords } from "../view/figures";
import { replayedNumbers } from "../view/robotNumbers";
import { type Code, figure, locale, t } from "../words/words";
import { reasonWords } from "./reasons";

const KEPT = {
  host: "replay.kept.host",
  operator: "replay.kept.operator",
  fault: "replay.kept.fault",
} as const satisfies Record<NonNullable<TapePart["kept"]>, Code>;

/** Returns what describes a part in the list: when it began, its size, why it is kept. */
export function partWords(where = locale()): (part: TapePart) => string {
  // Creating the format takes longer than using it, and a week has ten thousand parts.
  const time = new Intl.DateTimeFormat(where, { dateStyle: "medium", timeStyle: "medium" });
  return (part) => {
    const size = t("replay.part.size", { mb: figure(part.size_bytes / 1e6, 1) });
    const kept = part.kept ? [t(KEPT[part.kept])] : [];
    return [time.format(part.began_wall_ms), size, ...kept].join(", ");
  };
}

/** A time within a part: `1:05.3`. */
export function clockWords(ms: number): string {
  const tenths = Math.max(0, Math.floor(ms / 100));
  const seconds = Math.floor(tenths / 10) % 60;
  return `${Math.floor(tenths / 600)}:${String(seconds).padStart(2, "0")}.${tenths % 10}`;
}

/** The operator's command. */
export function commandWords(command: Commanded | null): string {
  if (!command) return t("replay.command.none");
  if (!command.held) return t("replay.command.released");
  const { linear, angular, lateral = 0 } = command;
  const along = linear > 0 ? "replay.command.forward" : "replay.command.back";
  const aside = lateral > 0 ? "replay.command.lateral_left" : "replay.command.lateral_right";
  const around = angular > 0 ? "replay.command.left" : "replay.command.right";
  const held = [
    ...(linear === 0 ? [] : [t(along, { share: percent(linear) })]),
    ...(lateral === 0 ? [] : [t(aside, { share: percent(lateral) })]),
    ...(angular === 0 ? [] : [t(around, { share: percent(angular) })]),
    ...Object.keys(command.axes),
  ];
  const speed = t(command.speed === "slow" ? "replay.command.slow" : "replay.command.fast");
  return [held.join(", ") || t("replay.command.still"), speed].join("; ");
}

/** What became of the command: the robot's set-point, and what holds or slows the robot. */
export function steeredWords(steered: Steered | null): string {
  if (!steered) return t("replay.unknown");
  const what = motionWords(steered);
  const why = steered.reason ?? steered.limit;
  return why ? t("replay.why", { what, why: reasonWords(why) }) : what;
}

function motionWords({ linear_mps, angular_rps, lateral_mps = 0 }: Steered): string {
  if (linear_mps === 0 && angular_rps === 0 && lateral_mps === 0) return t("replay.stands");
  const said = { ahead: figure(linear_mps, 2), turning: figure(angular_rps, 2) };
  if (lateral_mps === 0) return t("replay.motion", said);
  return t("replay.motion.sideways", { ...said, aside: figure(lateral_mps, 2) });
}

/** What the robot reports; a problem in its driver's own words. */
export function reportedWords(reported: Reported | null): string {
  if (!reported) return t("replay.unknown");
  const { connected, problem, moving, bumpers } = reported;
  if (!connected) return t("replay.robot.unconnected");
  const said = [
    ...(problem ? [problem] : []),
    ...(moving === null ? [] : [t(moving ? "replay.robot.turns" : "replay.robot.stands")]),
    ...(bumpers ? [t("replay.robot.bumper")] : []),
    ...replayedNumbers(reported),
  ];
  return said.join(", ") || t("replay.robot.nothing");
}

/** The ages at the operator, and why so little was sent, in the words recorded then. */
export function watchedWords(watched: Watched | null): string {
  if (!watched) return t("replay.unknown");
  const { picture_ms, sound_ms, round_trip_ms, rendition, why } = watched;
  return [
    t("replay.watched.picture", { age: age(picture_ms) }),
    t("replay.watched.sound", { age: age(sound_ms) }),
    t("replay.watched.link", { age: age(round_trip_ms) }),
    rendition ? sizeWords(rendition) : t("replay.watched.not_sent"),
    ...(why ? [why] : []),
  ].join("; ");
}

function age(ms: number | null): string {
  return ms === null ? t("replay.unknown") : msWords(ms);
}

function percent(share: number): string {
  return figure(Math.round(Math.abs(share) * 100));
}
