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
"""Later than the age at which the robot slows down, as it is shipped."""


class LateCamera:
    """The test card of `LATE_S` ago, with the time at which that was captured."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._card = TestCardVideo(settings, clock)
        self._under_way: deque[Picture] = deque()

    def open(self) -> None:
        self._card.open()

    def read(self) -> Picture:
        """Return the newest picture that is late enough, on a busy machine not each of them.

        A fixed number of pictures would be later and later, the fewer of them come in a second.
        """
        while True:
            newest = self._card.read()
            self._under_way.append(newest)
            arrived: Picture | None = None
            while self._under_way[0].captured_s <= newest.captured_s - LATE_S:
                arrived = self._under_way.popleft()
            if arrived is not None:
                return arrived

    def close(self) -> None:
        self._under_way.clear()
        self._card.close()
