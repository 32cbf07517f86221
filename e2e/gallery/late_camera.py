"""A camera for the gallery, an ordinary plug-in: its pictures come late, as over a slow network."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from wax.capture.testcard import TestCardVideo

if TYPE_CHECKING:
    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.settings import VideoSettings

LATE_S: Final = 0.5
"""Between the ages at which the robot slows down and stops, as they are shipped."""


class LateCamera:
    """The test card of `LATE_S` ago, with the time at which that was captured."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._card = TestCardVideo(settings, clock)
        self._length = max(1, round(LATE_S * settings.fps))
        self._under_way: deque[Picture] = deque()

    def open(self) -> None:
        self._card.open()

    def read(self) -> Picture:
        while len(self._under_way) < self._length:
            self._under_way.append(self._card.read())
        self._under_way.append(self._card.read())
        return self._under_way.popleft()

    def close(self) -> None:
        self._under_way.clear()
        self._card.close()
