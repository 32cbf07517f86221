"""The commanded speed, lowered by each rule that applies.

A rule scales both parts of the twist by the same factor, so that a curve keeps its radius.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.control.reasons import Limit
from wax.control.stopping_distance import fastest_mps
from wax.control.video_freshness import VideoFreshness
from wax.driver.interface import Twist

if TYPE_CHECKING:
    from wax.control.command import Command
    from wax.control.rules import Rules

_SLOW = {VideoFreshness.LATE: Limit.LATE_PICTURE, VideoFreshness.OFF: Limit.NO_PICTURE}


def twist(
    command: Command,
    freshness: VideoFreshness,
    ttl_s: float,
    rules: Rules,
    max_fraction: float = 1.0,
) -> tuple[Twist, Limit | None]:
    """Return the twist for a command, and the last rule that lowered it.

    The host allows `max_fraction` of the robot's limits.
    """
    limit = None
    shares = Twist(command.linear, command.angular)
    if command.speed == "slow":
        shares = _scaled(shares, rules.slow_fraction)
    largest = max(abs(shares.linear_mps), abs(shares.angular_rps))
    if largest > max_fraction:
        shares, limit = _scaled(shares, max_fraction / largest), Limit.BY_HOST
        largest = max_fraction
    if freshness in _SLOW and largest > rules.slow_fraction:
        shares, limit = _scaled(shares, rules.slow_fraction / largest), _SLOW[freshness]
    wanted = Twist(
        shares.linear_mps * rules.limits.linear_mps, shares.angular_rps * rules.limits.angular_rps
    )
    fastest = fastest_mps(ttl_s, rules)
    ahead_mps = abs(wanted.linear_mps)
    if ahead_mps > fastest:
        limit = _stopping(ahead_mps, rules)
        wanted = _scaled(wanted, fastest / ahead_mps)
    return wanted, limit


def share(command: Command | None, lowered: Twist, rules: Rules) -> float:
    """Return the fraction of the commanded speed that is left, 1 where none is commanded."""
    if command is None:
        return 1.0
    own = rules.slow_fraction if command.speed == "slow" else 1.0
    linear_mps = abs(own * command.linear * rules.limits.linear_mps)
    angular_rps = abs(own * command.angular * rules.limits.angular_rps)
    # Both parts are scaled alike; one may be zero, through its limit or through rounding.
    asked, left = max(
        (linear_mps, abs(lowered.linear_mps)), (angular_rps, abs(lowered.angular_rps))
    )
    return min(1.0, left / asked) if asked > 0 else 1.0


def _stopping(wanted_mps: float, rules: Rules) -> Limit:
    """Distinguish a long link from a robot that could not stop in time even without delay."""
    is_delay = wanted_mps <= fastest_mps(rules.max_age_s, rules)
    return Limit.LONG_DELAY if is_delay else Limit.STOPPING_DISTANCE


def _scaled(one: Twist, factor: float) -> Twist:
    return Twist(one.linear_mps * factor, one.angular_rps * factor)
