/** The server's rules for when something fails, in sentences. */

import type { Hello, LossRules } from "../messages";

export function lossSentences({ on_loss, robot, grace_s }: Hello): string[] {
  const { slow_picture_age_ms, stop_picture_age_ms } = on_loss;
  return [
    `The robot obeys a command for ${on_loss.max_age_ms} ms plus your connection's own delay, ` +
      `${on_loss.max_command_age_ms} ms at most. Then it stops. On a slower connection you can ` +
      "watch but not drive.",
    "If this page loses the keyboard, is hidden, frozen or closed, or the system takes your " +
      "finger off a control, it lets go of everything at once.",
    `If your picture is more than ${slow_picture_age_ms} ms older than the connection explains, ` +
      `you can only drive slowly; at more than ${stop_picture_age_ms} ms the robot stops. With ` +
      "the picture switched off you can only drive slowly.",
    `If commands or the picture fail for less than ${on_loss.resume_within_ms} ms, a control ` +
      "that you still hold drives on, and the robot speeds up again. After a longer gap, let go " +
      "of everything first.",
    `If nothing is heard from you for ${on_loss.lost_after_ms} ms, your connection counts as ` +
      `lost and the robot stops. Come back within ${grace_s} s to keep the rest of your turn, ` +
      "and let go of everything first.",
    on_loss.soft_braking
      ? "When you let go, or commands or the picture fail, this robot slows down gently. Stop, a " +
        "lost connection, a fault and the end of a turn stop it at once."
      : "Whatever stops the robot stops it at once.",
    `It never drives so fast that it would travel more than ${on_loss.max_stop_distance_m} m ` +
      `after losing its operator, and never faster than ${robot.max_linear_mps} m/s.`,
    watchdogSentence(on_loss),
    on_loss.stop_by === "everybody"
      ? "Everybody who watches can press Stop. The robot stands until the operator or the host " +
        "releases the stop; the release itself moves nothing."
      : "Only the operator and the host can press Stop. The robot stands until one of them " +
        "releases the stop; the release itself moves nothing.",
    "The Stop button is not an emergency stop: that is a switch in the robot's power line.",
  ];
}

function watchdogSentence({ silence_ms, robot_ttl_ms }: LossRules): string {
  const itself =
    robot_ttl_ms === null
      ? "nobody knows whether this robot stops by itself"
      : `the robot stops by itself after ${robot_ttl_ms} ms`;
  return silence_ms === null
    ? `The server controls this robot directly: if the server fails, ${itself}.`
    : `If the server fails, a separate program stops the robot after ${silence_ms} ms. If that ` +
        `fails too, ${itself}.`;
}
