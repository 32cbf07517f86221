/** The server's rules for when something fails, in sentences. */

import type { Hello, LossRules } from "../messages";
import { figure, t } from "../words/words";

export function lossSentences({ on_loss, robot, grace_s }: Hello): string[] {
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
      speed: figure(robot.max_linear_mps),
    }),
    watchdogSentence(on_loss),
    on_loss.stop_by === "everybody" ? t("rules.everybody_stops") : t("rules.operator_stops"),
    t("rules.no_emergency_stop"),
  ];
}

function watchdogSentence({ silence_ms, robot_ttl_ms }: LossRules): string {
  const ttl = robot_ttl_ms === null ? null : figure(robot_ttl_ms);
  if (silence_ms === null) {
    return ttl === null ? t("rules.direct_unknown") : t("rules.direct", { ttl });
  }
  const silence = figure(silence_ms);
  return ttl === null
    ? t("rules.watchdog_unknown", { silence })
    : t("rules.watchdog", { silence, ttl });
}
