"""The ramp: the robot accelerates at the configured rate and slows down at once.

The robot slows down at the braking rate only if the gate calls the set-point `soft` and the
configuration asks for soft braking. To reverse, it slows down, then accelerates the other way.
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
    return Twist(
        _part(
            target.linear_mps,
            now.linear_mps,
            after_s,
            faster=rules.acceleration_mps2,
            slower=rules.braking_mps2 if is_soft else math.inf,
        ),
        _part(
            target.angular_rps,
            now.angular_rps,
            after_s,
            faster=rules.acceleration_rps2,
            slower=rules.braking_rps2 if is_soft else math.inf,
        ),
    )


def _part(target: float, now: float, after_s: float, *, faster: float, slower: float) -> float:
    way = math.copysign(1.0, now)
    kept = max(0.0, min(abs(now), target * way))  # the part of the speed that the target keeps
    slowing_s = (abs(now) - kept) / slower
    if slowing_s > after_s:
        return way * max(kept, abs(now) - slower * after_s)
    gained = faster * (after_s - slowing_s)
    rest = target * way - kept
    return target if abs(rest) <= gained else way * (kept + math.copysign(gained, rest))
