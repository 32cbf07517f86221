"""Odometry from the wheels' encoders: whether the robot moves, how fast, and where it is (pure)."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Final

from wax.driver.interface import Pose

if TYPE_CHECKING:
    from wax.robot.gpio.pins import Steps

WINDOW_S: Final = 0.2
"""A wheel without a step for this long stands still."""


class StepOdometry:
    """Adds up steps; forward is positive, whichever way an encoder or a motor is wired."""

    def __init__(self, steps_per_m: float, wheel_base_m: float) -> None:
        self._m_per_step = 1.0 / steps_per_m
        self._wheel_base_m = wheel_base_m
        self._last: Steps | None = None
        self._seen: deque[tuple[float, Steps]] = deque()
        self.pose = Pose(0.0, 0.0, 0.0)

    def take(self, steps: Steps, now_s: float) -> None:
        """Update with the present counts."""
        if self._last is not None:
            self._roll(steps[0] - self._last[0], steps[1] - self._last[1])
        self._last = steps
        self._seen.append((now_s, steps))
        while len(self._seen) > 1 and now_s - self._seen[0][0] > WINDOW_S:
            self._seen.popleft()

    @property
    def moving(self) -> bool:
        """Whether a wheel has turned within the last `WINDOW_S`, either way."""
        return len({steps for _, steps in self._seen}) > 1

    @property
    def speed_mps(self) -> float:
        """The mean speed over the last `WINDOW_S`."""
        if len(self._seen) < 2:
            return 0.0
        (from_s, first), (to_s, last) = self._seen[0], self._seen[-1]
        rolled_m = (sum(last) - sum(first)) / 2.0 * self._m_per_step
        return rolled_m / (to_s - from_s) if to_s > from_s else 0.0

    def _roll(self, left: int, right: int) -> None:
        left_m, right_m = left * self._m_per_step, right * self._m_per_step
        turned_rad = (right_m - left_m) / self._wheel_base_m
        along_rad = self.pose.heading_rad + turned_rad / 2.0
        rolled_m = (left_m + right_m) / 2.0
        self.pose = Pose(
            self.pose.x_m + rolled_m * math.cos(along_rad),
            self.pose.y_m + rolled_m * math.sin(along_rad),
            math.remainder(self.pose.heading_rad + turned_rad, math.tau),
        )
