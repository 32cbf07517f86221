"""The ramp: the robot accelerates at the configured rate and slows down at once.

The robot slows down at the braking rate only if the gate calls the set-point `soft` and the
configuration asks for soft braking. To reverse, it slows down, then accelerates the other way; to
move in another direction, it slows down to the part of its speed that points there, and accelerates
from that. Ahead and sideways are one vector.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from wax.driver.interface import Twist

if TYPE_CHECKING:
    from wax.control.gate import Setpoint
    from wax.control.local_hand import HandRules
    from wax.control.rules import Rules


def step(target: Setpoint, now: Twist, after_s: float, rules: Rules) -> Setpoint:
    """Return this tick's set-point on the way to `target`, `after_s` after the last one.

    A late tick takes no larger step than two ticks would.
    """
    after_s = min(max(0.0, after_s), 2 * rules.period_s)
    return replace(target, twist=towards(target.twist, now, after_s, rules, soft=target.soft))


def towards(
    target: Twist, now: Twist, after_s: float, rules: Rules | HandRules, *, soft: bool
) -> Twist:
    """Return the twist `after_s` after `now` on the way to `target`, never beyond it."""
    is_soft = soft and rules.soft_braking
    ahead, left = _vector(
        (target.linear_mps, target.lateral_mps),
        (now.linear_mps, now.lateral_mps),
        after_s,
        faster=rules.acceleration_mps2,
        slower=rules.braking_mps2 if is_soft else math.inf,
    )
    turning, _ = _vector(
        (target.angular_rps, 0.0),
        (now.angular_rps, 0.0),
        after_s,
        faster=rules.acceleration_rps2,
        slower=rules.braking_rps2 if is_soft else math.inf,
    )
    return Twist(ahead, turning, left)


def _vector(
    target: tuple[float, float],
    now: tuple[float, float],
    after_s: float,
    *,
    faster: float,
    slower: float,
) -> tuple[float, float]:
    """Slow down, in the direction of `now`, to what `target` keeps of it; then go straight there.

    From standstill the direction is that of `target` from the first step.
    """
    speed = math.hypot(*now)
    way = (now[0] / speed, now[1] / speed) if speed else now
    kept = max(0.0, min(speed, target[0] * way[0] + target[1] * way[1]))
    slowing_s = (speed - kept) / slower
    if slowing_s > after_s:
        slowed = max(kept, speed - slower * after_s)
        return way[0] * slowed, way[1] * slowed
    start = (way[0] * kept, way[1] * kept)
    rest = (target[0] - start[0], target[1] - start[1])
    length = math.hypot(*rest)
    gained = faster * (after_s - slowing_s)
    if length <= gained:
        return target
    return start[0] + rest[0] / length * gained, start[1] + rest[1] / length * gained
