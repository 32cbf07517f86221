"""The commanded speed, lowered by each rule that applies.

A rule scales all parts of the twist by the same factor, so that a curve keeps its radius. Ahead
and sideways count together, as the length of one vector.
"""

from __future__ import annotations

import math
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
    shares, largest = _shares(command, rules)
    if largest > max_fraction:
        shares, limit = shares.scaled(max_fraction / largest), Limit.BY_HOST
        largest = max_fraction
    if freshness in _SLOW and largest > rules.slow_fraction:
        shares, limit = shares.scaled(rules.slow_fraction / largest), _SLOW[freshness]
    wanted = _at_most(shares, rules)
    fastest = fastest_mps(ttl_s, rules)
    if wanted.speed_mps > fastest:
        limit = _stopping(wanted.speed_mps, rules)
        wanted = wanted.scaled(fastest / wanted.speed_mps)
    return wanted, limit


def share(command: Command | None, lowered: Twist, rules: Rules) -> float:
    """Return the fraction of the commanded speed that is left, 1 where none is commanded."""
    if command is None:
        return 1.0
    own = _at_most(_shares(command, rules)[0], rules)
    # All parts are scaled alike; one may be zero, through its limit or through rounding.
    asked, left = max(
        (own.speed_mps, lowered.speed_mps), (abs(own.angular_rps), abs(lowered.angular_rps))
    )
    return min(1.0, left / asked) if asked > 0 else 1.0


def _shares(command: Command, rules: Rules) -> tuple[Twist, float]:
    """Return what a command asks for, as fractions of the limits, and the largest of them.

    Ahead and sideways held at once ask for full speed in between, not for 1.41 times that. The
    largest is exact: by the length of the rounded vector, full speed may exceed the limit.
    """
    lateral = command.lateral if rules.limits.lateral_mps > 0 else 0.0
    own = rules.slow_fraction if command.speed == "slow" else 1.0
    length = math.hypot(command.linear, lateral)
    excess = max(1.0, length)
    shares = Twist(command.linear / excess, command.angular, lateral / excess).scaled(own)
    return shares, own * max(min(1.0, length), abs(command.angular))


def _at_most(shares: Twist, rules: Rules) -> Twist:
    """Return the speeds that fractions of the limits stand for."""
    limits = rules.limits
    return Twist(
        shares.linear_mps * limits.linear_mps,
        shares.angular_rps * limits.angular_rps,
        shares.lateral_mps * limits.lateral_mps,
    )


def _stopping(wanted_mps: float, rules: Rules) -> Limit:
    """Distinguish a long link from a robot that could not stop in time even without delay."""
    is_delay = wanted_mps <= fastest_mps(rules.max_age_s, rules)
    return Limit.LONG_DELAY if is_delay else Limit.STOPPING_DISTANCE
