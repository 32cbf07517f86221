/** What the robot does when something fails, in sentences; the server's rules, not the page's. */

import type { Hello, LossRules } from "../messages";

export function lossSentences({ on_loss, robot, grace_s }: Hello): string[] {
  return [
    `The robot obeys a command for ${on_loss.max_age_ms} ms beyond the line's own time, ` +
      `together ${on_loss.max_command_age_ms} ms at most. Then it stops. Over a line that is ` +
      "slower you can watch, not drive.",
    "When this page loses the keyboard, is hidden, frozen or closed, or a finger is taken from " +
      "it, it lets go of everything at once.",
    `Who sees a picture more than ${on_loss.slow_picture_age_ms} ms older than the line explains ` +
      `drives no faster than slow speed; with more than ${on_loss.stop_picture_age_ms} ms the robot ` +
      "stops. With the picture switched off it drives no faster than slow speed.",
    `If commands or picture are gone for less than ${on_loss.resume_within_ms} ms, what is still ` +
      "held drives on by itself, and the robot gathers speed again. After a longer gap let go of " +
      "everything first.",
    `Whoever drives and is not heard for ${on_loss.lost_after_ms} ms counts as lost: the robot ` +
      `stands. Who is back within ${grace_s} s has what is left of the turn, and lets go of ` +
      "everything first.",
    on_loss.soft_braking
      ? "When whoever drives lets go, or commands or picture fail, this robot slows down gently. " +
        "Stop, a lost connection, a fault and the end of a turn stop it at once."
      : "Whatever makes the robot stop stops it at once, not gently.",
    `It never drives so fast that it would travel more than ${on_loss.max_stop_distance_m} m ` +
      `after its operator is lost, nor faster than ${robot.max_linear_mps} m/s.`,
    watchdogSentence(on_loss),
    on_loss.stop_by === "everybody"
      ? "Everybody who watches can press Stop. It holds until whoever drives, or the host, " +
        "releases it; that alone moves nothing."
      : "Only whoever drives, or the host, can press Stop. It holds until one of them releases " +
        "it; that alone moves nothing.",
    "A stop button here is not an emergency stop: that is a switch in the robot's power line.",
  ];
}

function watchdogSentence({ silence_ms, robot_ttl_ms }: LossRules): string {
  const itself =
    robot_ttl_ms === null
      ? "whether this robot would stop by itself is not known"
      : `the robot stops by itself after ${robot_ttl_ms} ms`;
  return silence_ms === null
    ? `The server itself speaks with this robot: when it fails, ${itself}.`
    : `When the server fails, what speaks with the robot stops it after ${silence_ms} ms. When ` +
        `that fails too, ${itself}.`;
}
