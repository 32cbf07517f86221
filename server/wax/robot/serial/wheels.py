"""From a twist to the speeds of two wheels (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.driver.checks import within
from wax.driver.interface import Limits

if TYPE_CHECKING:
    from wax.config.settings import RobotSettings
    from wax.driver.interface import Twist

MAX_WHEEL_MPS: Final = 32.767
"""What a signed 16 bit number of millimetres a second can say."""


@dataclass(frozen=True, slots=True)
class WheelSpeeds:
    """Left and right in m/s, ahead positive before an inversion."""

    left_mps: float
    right_mps: float


class WheelMixer:
    """Knows the robot's base: how far its wheels are apart, how they differ, which way they turn.

    A wheel is as fast as the limits let it be straight ahead or on the spot, never faster. When
    a curve asks for more, both are slowed by one factor, so that it stays the same curve.
    """

    def __init__(self, settings: RobotSettings) -> None:
        self._limits = Limits(settings.max_linear_mps, settings.max_angular_rps)
        self._half_base_m = settings.wheel_base_m / 2.0
        on_the_spot_mps = settings.max_angular_rps * self._half_base_m
        self._max_wheel_mps = min(MAX_WHEEL_MPS, max(settings.max_linear_mps, on_the_spot_mps))
        self._left = settings.left_trim * (-1.0 if settings.invert_left else 1.0)
        self._right = settings.right_trim * (-1.0 if settings.invert_right else 1.0)

    def mix(self, twist: Twist) -> WheelSpeeds:
        """Give the wheels' speeds, trimmed and turned round as configured; NaN is standstill."""
        allowed = within(twist, self._limits)
        aside_mps = allowed.angular_rps * self._half_base_m
        left, right = allowed.linear_mps - aside_mps, allowed.linear_mps + aside_mps
        excess = max(1.0, abs(left) / self._max_wheel_mps, abs(right) / self._max_wheel_mps)
        return WheelSpeeds(left / excess * self._left, right / excess * self._right)
