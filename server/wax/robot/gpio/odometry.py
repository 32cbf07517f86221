"""Odometry from the wheels' encoders: whether the robot moves, how fast, and where it is (pure)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from wax.driver.interface import STANDSTILL, Pose

if TYPE_CHECKING:
    from wax.driver.interface import Twist
    from wax.robot.gpio.pins import Steps
    from wax.robot.wheels import WheelGeometry

WINDOW_S: Final = 0.2
"""A wheel without a step for this long stands still."""


class StepOdometry:
    """Adds up steps; forward is positive, whichever way an encoder or a motor is wired."""

    def __init__(self, steps_per_m: float, wheels: WheelGeometry) -> None:
        self._m_per_step = 1.0 / steps_per_m
        self._wheels = wheels
        self._last: Steps | None = None
        self._seen: deque[tuple[float, Steps]] = deque()
        self.pose = Pose(0.0, 0.0, 0.0)

    def take(self, steps: Steps, now_s: float) -> None:
        """Update with the present counts."""
        if self._last is not None:
            rolled_m = [one * self._m_per_step for one in _between(self._last, steps)]
            self.pose = self._wheels.moved(self.pose, rolled_m)
        self._last = steps
        self._seen.append((now_s, steps))
        while len(self._seen) > 1 and now_s - self._seen[0][0] > WINDOW_S:
            self._seen.popleft()

    @property
    def moving(self) -> bool:
        """Whether a wheel has turned within the last `WINDOW_S`, either way."""
        return len({steps for _, steps in self._seen}) > 1

    @property
    def motion(self) -> Twist:
        """The mean motion over the last `WINDOW_S`."""
        if len(self._seen) < 2:
            return STANDSTILL
        (from_s, first), (to_s, last) = self._seen[0], self._seen[-1]
        if to_s <= from_s:
            return STANDSTILL
        return self._wheels.motion(_between(first, last)).scaled(self._m_per_step / (to_s - from_s))


def _between(before: Steps, after: Steps) -> list[int]:
    return [now - was for was, now in zip(before, after, strict=True)]
