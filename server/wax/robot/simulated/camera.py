"""The simulated robot's cameras as `VideoSource`s."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final, Protocol

from wax.capture.source import REST_S, Picture
from wax.errors import SourceError
from wax.robot.simulated.frame_timer import FrameTimer
from wax.robot.simulated.lamp import lit

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.video import VideoSettings
    from wax.driver.interface import Pose
    from wax.robot.simulated.simulation import Senses


class Artist(Protocol):
    """Draws the flat with the robot at a pose, its head turned `pan_rad` to the left."""

    def draw(self, pose: Pose, pan_rad: float) -> NDArray[np.uint8]:
        """Return a BGR array ``(height, width, 3)``, which the next call may overwrite."""


class SimulatedCamera:
    """Shows what an artist draws, at the size and rate of the settings.

    `artist` makes one for a width and a height; `look` returns the robot's pose, whose time is the
    picture's capture time. `is_lit` adds the light of the robot's lamp.
    """

    rest_s: Final = REST_S

    def __init__(
        self,
        settings: VideoSettings,
        clock: Clock,
        *,
        artist: Callable[[int, int], Artist],
        look: Callable[[], Senses],
        is_lit: bool = False,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._make_artist = artist
        self._look = look
        self._is_lit = is_lit
        self._closed = threading.Event()
        self._artist: Artist | None = None
        self._pacer: FrameTimer | None = None

    def open(self) -> None:
        self._closed.clear()
        self._artist = self._make_artist(self._settings.width, self._settings.height)
        self._pacer = FrameTimer(1.0 / self._settings.fps, self._clock, self._closed.wait)

    def read(self) -> Picture:
        if self._artist is None or self._pacer is None:
            raise SourceError("The robot's camera was read before it was opened.")
        self._pacer.beat()
        senses = self._look()
        image = self._artist.draw(senses.pose, senses.pan_rad)
        if self._is_lit:
            image = lit(image, senses.lamp)
        return Picture.from_bgr(image, senses.at_s, within_s=0.0)

    def close(self) -> None:
        self._closed.set()
        self._artist = None
        self._pacer = None
