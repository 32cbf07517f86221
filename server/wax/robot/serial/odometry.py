"""Computes the robot's pose and wheel speeds from encoder ticks (pure)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.driver.interface import Pose
from wax.robot.wheels import WheelSpeeds

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings

FASTEST_MPS: Final = 10.0
SLACK_M: Final = 0.2
"""If a wheel went this much further than its top speed allows, its counter was reset."""

_TURNED: Final = 2**32


class Odometry:
    """Integrates the wheels' motion, starting at 0; never raises, whatever is reported.

    Ticks have the sign of the speeds sent to the robot, so an inverted wheel counts backward. They
    may wrap at 32 bits. If `ticks_per_m` is 0, nothing is known.
    """

    def __init__(self, settings: RobotSettings) -> None:
        self._ticks_per_m = settings.serial.ticks_per_m
        self._base_m = settings.wheel_base_m
        self._signs = (
            -1.0 if settings.invert_left else 1.0,
            -1.0 if settings.invert_right else 1.0,
        )
        self._last: tuple[int, int, float] | None = None
        self._x_m = self._y_m = self._heading_rad = 0.0
        self._speeds: WheelSpeeds | None = None

    @property
    def pose(self) -> Pose | None:
        """The pose, None before the second report or without a scale."""
        if self._speeds is None:
            return None
        return Pose(self._x_m, self._y_m, self._heading_rad)

    @property
    def speeds(self) -> WheelSpeeds | None:
        """How fast the wheels turned between the last two reports."""
        return self._speeds

    def forget(self) -> None:
        """Begin a connection: keep the pose, but expect reset counters."""
        self._last = self._speeds = None

    def take(self, left_ticks: int, right_ticks: int, at_s: float) -> None:
        """Add one report; `at_s` is on any monotonic clock."""
        last, self._last = self._last, (left_ticks, right_ticks, at_s)
        if last is None or self._ticks_per_m == 0.0:
            return
        elapsed_s = at_s - last[2]
        left_m = _between(last[0], left_ticks) / self._ticks_per_m * self._signs[0]
        right_m = _between(last[1], right_ticks) / self._ticks_per_m * self._signs[1]
        believed_m = FASTEST_MPS * elapsed_s + SLACK_M
        if elapsed_s <= 0.0 or max(abs(left_m), abs(right_m)) > believed_m:
            self._speeds = None
            return
        self._speeds = WheelSpeeds(left_m / elapsed_s, right_m / elapsed_s)
        turned_rad = (right_m - left_m) / self._base_m
        # Moving straight along the mean heading is exact to third order.
        middle_rad = self._heading_rad + turned_rad / 2.0
        ahead_m = (left_m + right_m) / 2.0
        self._x_m += ahead_m * math.cos(middle_rad)
        self._y_m += ahead_m * math.sin(middle_rad)
        self._heading_rad = math.remainder(self._heading_rad + turned_rad, math.tau)


def _between(before: int, after: int) -> int:
    return (after - before + _TURNED // 2) % _TURNED - _TURNED // 2
