"""The simulated robot's camera as a `VideoSource`."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from wax.capture.source import Picture
from wax.errors import SourceError
from wax.robot.simulated.frame_timer import FrameTimer
from wax.robot.simulated.render import Renderer

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config.settings import VideoSettings
    from wax.robot.simulated.simulation import Senses
    from wax.robot.simulated.world import World


class SimulatedCamera:
    """Draws the robot's view, at the size and rate of the settings.

    `look` returns the robot's pose; a picture's capture time is the time of that pose.
    """

    def __init__(
        self, settings: VideoSettings, clock: Clock, *, world: World, look: Callable[[], Senses]
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._world = world
        self._look = look
        self._closed = threading.Event()
        self._renderer: Renderer | None = None
        self._pacer: FrameTimer | None = None

    def open(self) -> None:
        self._closed.clear()
        self._renderer = Renderer(self._world, self._settings.width, self._settings.height)
        self._pacer = FrameTimer(1.0 / self._settings.fps, self._clock, self._closed.wait)

    def read(self) -> Picture:
        if self._renderer is None or self._pacer is None:
            raise SourceError("The robot's camera was read before it was opened.")
        self._pacer.beat()
        senses = self._look()
        bgr = self._renderer.draw(senses.pose, senses.pan_rad)
        return Picture.from_bgr(bgr, senses.at_s)

    def close(self) -> None:
        self._closed.set()
        self._renderer = None
        self._pacer = None
