"""Converts a twist to the speeds of two wheels (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.driver.checks import within
from wax.driver.interface import Limits

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Twist

MAX_WHEEL_MPS: Final = 32.767
"""The largest speed in a signed 16-bit number of mm/s."""


@dataclass(frozen=True, slots=True)
class WheelSpeeds:
    """Left and right in m/s, forward positive before any inversion."""

    left_mps: float
    right_mps: float


class WheelMixer:
    """Converts a twist for the robot's wheel base, trim and inversions.

    The fastest that a wheel turns is its speed straight ahead, or on the spot, at the limits. If a
    curve needs more, both wheels are slowed by one factor, so that the curve keeps its radius.
    """

    def __init__(self, settings: RobotSettings) -> None:
        self._limits = Limits(settings.max_linear_mps, settings.max_angular_rps)
        self._half_base_m = settings.wheel_base_m / 2.0
        on_the_spot_mps = settings.max_angular_rps * self._half_base_m
        self._max_wheel_mps = min(MAX_WHEEL_MPS, max(settings.max_linear_mps, on_the_spot_mps))
        self._left = settings.left_trim * (-1.0 if settings.invert_left else 1.0)
        self._right = settings.right_trim * (-1.0 if settings.invert_right else 1.0)

    def mix(self, twist: Twist) -> WheelSpeeds:
        """Return the wheel speeds, trimmed and inverted as configured; NaN gives standstill."""
        allowed = within(twist, self._limits)
        aside_mps = allowed.angular_rps * self._half_base_m
        left, right = allowed.linear_mps - aside_mps, allowed.linear_mps + aside_mps
        excess = max(1.0, abs(left) / self._max_wheel_mps, abs(right) / self._max_wheel_mps)
        return WheelSpeeds(left / excess * self._left, right / excess * self._right)
