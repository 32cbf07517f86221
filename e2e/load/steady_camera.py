"""A robot whose camera gives 30 pictures a second and costs nothing else, in any process."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import Picture
from wax.driver.interface import Limits, RobotState

if TYPE_CHECKING:
    from wax.capture.source import VideoSource
    from wax.clock import Clock
    from wax.config.settings import RobotSettings, VideoSettings
    from wax.driver.interface import Twist

RATE_HZ: Final = 30.0
DRIVER: Final = "e2e.load.steady_camera:SteadyRobot"


class SteadyCamera:
    """Its pictures were made beforehand, so that what is measured is their way."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        shape = (settings.height * 3 // 2, settings.width)
        chance = np.random.default_rng(7)
        self._pictures = [chance.integers(0, 255, shape, np.uint8) for _ in range(4)]
        self._clock = clock
        self._number = 0
        self._due_s = 0.0

    def open(self) -> None:
        self._due_s = time.monotonic()

    def read(self) -> Picture:
        self._number += 1
        self._due_s += 1.0 / RATE_HZ
        time.sleep(max(0.0, self._due_s - time.monotonic()))
        return Picture(self._pictures[self._number % 4], self._clock.now_s(), within_s=0.0)

    def close(self) -> None: ...


class SteadyRobot:
    """Does not move; sees."""

    kind = "steady"
    limits = Limits(0.6, 1.5, ttl_s=0.2)

    def __init__(self, settings: RobotSettings, clock: Clock) -> None: ...

    def open(self) -> None: ...

    def apply(self, twist: Twist, turn: int) -> None: ...

    def set_axis(self, name: str, position: float, turn: int) -> None: ...

    def stop(self, turn: int) -> None: ...

    def close(self) -> None: ...

    def state(self) -> RobotState:
        return RobotState(connected=True, epoch=1)

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return SteadyCamera(settings, clock)
