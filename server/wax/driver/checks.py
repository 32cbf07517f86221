"""What every driver checks for itself, whatever the control loop has checked before (pure).

And what is checked of every driver, by whoever holds it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.driver.interface import STANDSTILL, RobotState, Twist

if TYPE_CHECKING:
    from wax.driver.interface import Limits


NO_ANSWER: Final = "The robot does not answer."
"""The problem of a robot whose driver raises."""


class TurnFence:
    """Admit only the newest turn: its numbers only rise, so a lower one is somebody's past."""

    def __init__(self) -> None:
        self._highest: int | None = None

    def admits(self, turn: int) -> bool:
        """Say whether `turn` is the highest seen so far; a higher one closes the way behind it."""
        if self._highest is not None and turn < self._highest:
            return False
        self._highest = turn
        return True


def within(twist: Twist, limits: Limits) -> Twist:
    """Shrink `twist` into `limits`, both parts by one factor so that the curve stays the same.

    What is not a finite number is standstill. A limit of zero takes its part away, not the other.
    """
    if not (math.isfinite(twist.linear_mps) and math.isfinite(twist.angular_rps)):
        return STANDSTILL
    excess = max(
        1.0,
        _share(twist.linear_mps, limits.linear_mps),
        _share(twist.angular_rps, limits.angular_rps),
    )
    return Twist(
        linear_mps=_clamp(twist.linear_mps / excess, limits.linear_mps),
        angular_rps=_clamp(twist.angular_rps / excess, limits.angular_rps),
    )


def unit(position: float) -> float:
    """Clip an axis position to -1…1; what is not a number is the middle."""
    return _clamp(position, 1.0) if math.isfinite(position) else 0.0


def checked(state: object) -> RobotState:
    """Refuse what somebody's driver may return instead of a state; raises `TypeError`."""
    if not isinstance(state, RobotState):
        raise TypeError(f"the driver's state() returned {state!r}, not a RobotState")
    if not isinstance(state.bumpers, int):
        raise TypeError(f"the driver's state() has {state.bumpers!r} for bumpers, not their bits")
    return state


def _share(value: float, limit: float) -> float:
    return abs(value) / limit if limit > 0.0 else 0.0


def _clamp(value: float, limit: float) -> float:
    return min(limit, max(-limit, value))
