/** The server's rules for failures, in sentences. */

import type { Hello } from "../messages";
import { figure, t } from "../words/words";

/** The robot's own report of its watchdog, `told_ttl_ms`, outranks the host's configuration. */
export function lossSentences(
  { on_loss, robot, grace_s }: Hello,
  told_ttl_ms: number | null,
): string[] {
  return [
    t("rules.command_age", {
      age: figure(on_loss.max_age_ms),
      most: figure(on_loss.max_command_age_ms),
    }),
    t("rules.letting_go"),
    t("rules.picture_age", {
      slow: figure(on_loss.slow_picture_age_ms),
      stop: figure(on_loss.stop_picture_age_ms),
    }),
    t("rules.resuming", { within: figure(on_loss.resume_within_ms) }),
    t("rules.lost", { lost: figure(on_loss.lost_after_ms), grace: figure(grace_s) }),
    on_loss.soft_braking ? t("rules.soft_braking") : t("rules.hard_braking"),
    t("rules.distance", {
      distance: figure(on_loss.max_stop_distance_m),
      speed: figure(Math.max(robot.max_linear_mps, robot.max_lateral_mps ?? 0)),
    }),
    watchdogSentence(on_loss.silence_ms, told_ttl_ms ?? on_loss.robot_ttl_ms),
    on_loss.stop_by === "everybody" ? t("rules.everybody_stops") : t("rules.operator_stops"),
    t("rules.no_emergency_stop"),
  ];
}

function watchdogSentence(silence_ms: number | null, ttl_ms: number | null): string {
  if (silence_ms === null) {
    if (ttl_ms === null) return t("rules.direct_unknown");
    return ttl_ms === 0 ? t("rules.direct_never") : t("rules.direct", { ttl: figure(ttl_ms) });
  }
  const silence = figure(silence_ms);
  if (ttl_ms === null) return t("rules.watchdog_unknown", { silence });
  if (ttl_ms === 0) return t("rules.watchdog_never", { silence });
  return t("rules.watchdog", { silence, ttl: figure(ttl_ms) });
}
