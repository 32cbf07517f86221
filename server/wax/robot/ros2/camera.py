"""A source for the pictures that a ROS 2 robot publishes."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Any, Final

from wax.capture.letterbox import fit_bgr
from wax.capture.own_size import HD, fitted
from wax.capture.source import REST_S, Picture
from wax.capture.stream_dating import Dating, Repeats
from wax.errors import DriverError, SourceError
from wax.robot.ros2.images import to_bgr
from wax.robot.ros2.link import Wanted
from wax.robot.ros2.open_link import open_link
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.clock import Clock
    from wax.config.video import VideoSettings
    from wax.robot.ros2.link import Link
    from wax.robot.ros2.settings import Ros2Settings

SILENT_S: Final = 1.8
"""Without a picture for this long the camera counts as gone (the interface allows 2 s)."""
FIRST_S: Final = 8.0
"""Discovery of the robot may take longer, so `open` waits this long for the first picture."""
MAX_AGE_S: Final = 2.0
_AGREE_S: Final = 0.05
"""The error bound of two synchronised clocks."""
_KIND: Final = "camera"


class Ros2Camera:
    """A `VideoSource` of the configured topic, with a connection of its own.

    Pictures have the size of `settings`, or keep their own, up to HD, if that leaves it to them.

    With `stamped`, which says that both clocks agree, `captured_s` is the picture's own timestamp;
    an impossible one counts as unknown. Otherwise it is estimated from the arrival time and the
    timestamp's progress (`wax.capture.stream_dating`).
    """

    rest_s: Final = REST_S

    def __init__(self, ros2: Ros2Settings, settings: VideoSettings, clock: Clock) -> None:
        self._ros2 = ros2
        self._settings = settings
        self._clock = clock
        self._link: Link | None = None
        self._first: Any = None
        self._dating = Dating(stamped=True)
        self._repeats = Repeats()

    def open(self) -> None:
        self.close()
        self._dating, self._repeats = Dating(stamped=True), Repeats()
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

    def catch_up(self) -> None:
        """Drop what came during a rest: only its arrival would tell its age, and nobody saw it."""
        if self._link is not None:
            with _told():
                self._link.take(0.0)

    def read(self) -> Picture:
        """Return the next picture; skip repetitions of one, unless they persist."""
        end_s = self._clock.now_s() + SILENT_S
        while True:
            message, self._first = self._first or self._next(end_s - self._clock.now_s()), None
            picture = self._picture(message, self._clock.now_s())
            if picture is not None:
                return picture

    def _picture(self, message: Any, arrived_s: float) -> Picture | None:
        try:
            bgr = to_bgr(message)
        except ValueError as error:
            raise SourceError(
                Sentence("ros2.strange_picture", {"topic": self._ros2.camera, "what": str(error)})
            ) from error
        size = self._settings.width, self._settings.height
        if self._settings.has_auto_size:
            size = fitted(bgr.shape[1], bgr.shape[0], HD)
        shown = fit_bgr(bgr, *size)
        captured_s, within_s = self._captured_s(message, arrived_s)
        # A simulated camera has no noise: only the timestamp tells new from repeated pictures.
        repeats = self._repeats.of(shown.tobytes() + repr(_stamp_s(message)).encode(), arrived_s)
        if repeats == "again":
            return None
        return Picture.from_bgr(shown, captured_s, None if repeats == "old" else within_s)

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

    def _captured_s(self, message: Any, arrived_s: float) -> tuple[float, float | None]:
        """Return when it was captured, and the error bound of that (None: unknown)."""
        stamp_s = _stamp_s(message)
        if not self._ros2.stamped:
            shown_s = 0.0 if stamp_s is None else stamp_s
            zero_s, within_s = self._dating.date(0, shown_s, stamp_s, arrived_s)
            return zero_s + shown_s, within_s
        age_s = -1.0 if stamp_s is None else self._clock.wall_ms() / 1000.0 - stamp_s
        if not -_AGREE_S <= age_s <= MAX_AGE_S:
            return arrived_s, None
        return arrived_s - max(age_s, 0.0), _AGREE_S


def _stamp_s(message: Any) -> float | None:
    """Return the robot's timestamp, None if there is none."""
    with contextlib.suppress(AttributeError, TypeError, ValueError, OverflowError):
        stamp = message.header.stamp
        stamp_s = float(stamp.sec + stamp.nanosec / 1e9)
        return stamp_s if 0.0 < stamp_s < math.inf else None
    return None


@contextlib.contextmanager
def _told() -> Iterator[None]:
    try:
        yield
    except DriverError as error:
        raise SourceError(error.sentence) from error
