"""Checks that drivers apply to their input, and that callers apply to drivers (pure)."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from wax.driver.interface import STANDSTILL, Aboard, RobotState, Twist
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.driver.interface import Limits


MAX_GAUGES: Final = 32
"""The most gauges a driver may report, since its state is sent often."""

_MOST: Final = sys.float_info.max

NO_ANSWER: Final = Sentence("robot.no_answer")
"""The problem reported for a robot whose driver raises."""


class TurnFence:
    """Rejects calls of old turns: turn numbers only rise, so a lower number is of an old turn."""

    def __init__(self) -> None:
        self._highest: int | None = None

    def admits(self, turn: int) -> bool:
        """Whether `turn` is at least the highest seen so far; it then counts as seen."""
        if self._highest is not None and turn < self._highest:
            return False
        self._highest = turn
        return True


def within(twist: Twist, limits: Limits) -> Twist:
    """Scale `twist` into `limits`, all parts by one factor so that a curve keeps its radius.

    A number that is not finite gives standstill. A limit of zero removes only its own part.
    """
    if not all(map(math.isfinite, (twist.linear_mps, twist.angular_rps, twist.lateral_mps))):
        return STANDSTILL
    over = max(1.0, share_of(twist, limits))
    return Twist(
        linear_mps=_clamp(twist.linear_mps / over, limits.linear_mps),
        angular_rps=_clamp(twist.angular_rps / over, limits.angular_rps),
        lateral_mps=_clamp(twist.lateral_mps / over, limits.lateral_mps),
    )


def share_of(twist: Twist, limits: Limits) -> float:
    """Return which fraction of `limits` a twist uses, above 1 if it exceeds them.

    Ahead and sideways count together, as the length of one vector. A limit of zero counts for
    nothing.
    """
    return max(
        math.hypot(
            _share(twist.linear_mps, limits.linear_mps),
            _share(twist.lateral_mps, limits.lateral_mps),
        ),
        _share(twist.angular_rps, limits.angular_rps),
    )


def unit(position: float) -> float:
    """Clip an axis position to -1…1; NaN becomes 0, the middle."""
    return _clamp(position, 1.0) if math.isfinite(position) else 0.0


def checked(state: object) -> RobotState:
    """Return `state` if it is a valid state; raises `TypeError` for anything else.

    A gauge whose value is not a number is left out, as if the robot did not report it.
    """
    if not isinstance(state, RobotState):
        raise TypeError(f"the driver's state() returned {state!r}, not a RobotState")
    if not isinstance(state.bumpers, int):
        raise TypeError(f"the driver's state() has {state.bumpers!r} for bumpers, not their bits")
    if not isinstance(state.aboard, Aboard | None):
        raise TypeError(f"the driver's state() has {state.aboard!r} for aboard, not an Aboard")
    if not _are_gauges(state.gauges):
        raise TypeError(
            f"the driver's state() has {state.gauges!r} for gauges, not at most {MAX_GAUGES}"
            " numbers by name"
        )
    if not all(_is_number(value) for value in state.gauges.values()):
        known = {name: value for name, value in state.gauges.items() if _is_number(value)}
        state = replace(state, gauges=known)
    if not _is_time(state.ttl_s):
        raise TypeError(f"the driver's state() has {state.ttl_s!r} for ttl_s, not seconds or None")
    return state


def _is_time(ttl_s: object) -> bool:
    return ttl_s is None or (isinstance(ttl_s, int | float) and 0.0 <= ttl_s < math.inf)


def _are_gauges(gauges: object) -> bool:
    return (
        isinstance(gauges, Mapping)
        and len(gauges) <= MAX_GAUGES
        and all(isinstance(name, str) for name in gauges)
    )


def _is_number(value: object) -> bool:
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and -_MOST <= value <= _MOST
    )


def _share(value: float, limit: float) -> float:
    return abs(value) / limit if limit > 0.0 else 0.0


def _clamp(value: float, limit: float) -> float:
    return min(limit, max(-limit, value))
