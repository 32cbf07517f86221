"""The pictures that a robot on ROS 2 publishes."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Final

from wax.capture.letterbox import fit_bgr
from wax.capture.source import Picture
from wax.errors import DriverError, SourceError
from wax.robot.ros2.images import to_bgr
from wax.robot.ros2.link import Wanted, open_link
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.clock import Clock
    from wax.config.settings import VideoSettings
    from wax.robot.ros2.link import Link
    from wax.robot.ros2.settings import Ros2Settings

SILENT_S: Final = 1.8
"""Without a picture for this long the camera is gone (the interface allows 2 s)."""
FIRST_S: Final = 8.0
"""To find the robot may take longer, so `open` waits for its first picture."""
MAX_AGE_S: Final = 2.0
_KIND: Final = "camera"


class Ros2Camera:
    """A `VideoSource` of the configured topic, with a connection of its own.

    `captured_s` is the picture's own stamp where both clocks are said to agree (`stamped`), else
    when it arrived: exposure, encoding and the way are unknown then.
    """

    def __init__(self, ros2: Ros2Settings, settings: VideoSettings, clock: Clock) -> None:
        self._ros2 = ros2
        self._settings = settings
        self._clock = clock
        self._link: Link | None = None
        self._first: Any = None

    def open(self) -> None:
        self.close()
        if not self._ros2.camera:
            raise SourceError(Sentence("ros2.no_camera"))
        wanted = Wanted(_KIND, self._ros2.camera, self._ros2.camera_type)
        with _told():
            self._link = open_link(self._ros2, self._clock, wanted=[wanted])
        try:
            self._first = self._next(FIRST_S)
        except SourceError:
            self.close()
            raise

    def read(self) -> Picture:
        message, self._first = self._first or self._next(SILENT_S), None
        arrived_s = self._clock.now_s()
        try:
            bgr = to_bgr(message)
        except ValueError as error:
            raise SourceError(
                Sentence("ros2.strange_picture", {"topic": self._ros2.camera, "what": str(error)})
            ) from error
        fitted = fit_bgr(bgr, self._settings.width, self._settings.height)
        return Picture.from_bgr(fitted, arrived_s - self._age_s(message))

    def close(self) -> None:
        link, self._link, self._first = self._link, None, None
        if link is not None:
            link.close()

    def _next(self, within_s: float) -> Any:
        if self._link is None:
            raise SourceError(Sentence("ros2.no_picture", {"topic": self._ros2.camera}))
        end_s = self._clock.now_s() + within_s
        while (rest_s := end_s - self._clock.now_s()) > 0.0:
            with _told():
                heard = self._link.take(rest_s)
            if heard:
                return heard[-1][1]
        raise SourceError(Sentence("ros2.no_picture", {"topic": self._ros2.camera}))

    def _age_s(self, message: Any) -> float:
        """Return the age by the stamp; one that cannot be is taken as none."""
        if not self._ros2.stamped:
            return 0.0
        with contextlib.suppress(AttributeError, TypeError, ValueError):
            stamp = message.header.stamp
            age_s = self._clock.wall_ms() / 1000.0 - (stamp.sec + stamp.nanosec / 1e9)
            return age_s if 0.0 <= age_s <= MAX_AGE_S else 0.0
        return 0.0


@contextlib.contextmanager
def _told() -> Iterator[None]:
    try:
        yield
    except DriverError as error:
        raise SourceError(error.sentence) from error
