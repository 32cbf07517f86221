"""Computes the robot's pose and wheel speeds from encoder ticks (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.driver.interface import Pose
from wax.robot.wheels import WheelGeometry

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.bases import Base
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

    def __init__(self, settings: RobotSettings, base: Base | None = None) -> None:
        self._ticks_per_m = settings.serial.ticks_per_m
        self._wheels = WheelGeometry(settings, base)
        self._last: tuple[Sequence[int], float] | None = None
        self._pose = Pose(0.0, 0.0, 0.0)
        self._speeds: dict[str, float] = {}

    @property
    def pose(self) -> Pose | None:
        """The pose, None before the second report or without a scale."""
        return self._pose if self._speeds else None

    @property
    def speeds(self) -> dict[str, float]:
        """Each wheel's mean speed in m/s between the last two reports, empty if unknown."""
        return self._speeds

    def forget(self) -> None:
        """Begin a connection: keep the pose, but expect reset counters."""
        self._last, self._speeds = None, {}

    def take(self, ticks: Sequence[int], at_s: float) -> None:
        """Add one report of all wheels; `at_s` is on any monotonic clock."""
        last, self._last = self._last, (ticks, at_s)
        if last is None or self._ticks_per_m == 0.0:
            return
        before, elapsed_s = last[0], at_s - last[1]
        rolled_m = [
            _between(was, now) / self._ticks_per_m * sign
            for was, now, sign in zip(before, ticks, self._wheels.signs.values(), strict=True)
        ]
        believed_m = FASTEST_MPS * elapsed_s + SLACK_M
        if elapsed_s <= 0.0 or max(map(abs, rolled_m)) > believed_m:
            self._speeds = {}
            return
        self._speeds = {
            name: one / elapsed_s for name, one in zip(self._wheels.names, rolled_m, strict=True)
        }
        self._pose = self._wheels.moved(self._pose, rolled_m)


def _between(before: int, after: int) -> int:
    return (after - before + _TURNED // 2) % _TURNED - _TURNED // 2
