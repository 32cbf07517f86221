"""A camera beside the driving view, as the tape takes it from the fan-out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import structlog

from wax.error_boundary import ErrorBoundary
from wax.tape.camera_files import CameraFormat

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.settings import CameraSettings
    from wax.fanout.camera import Camera
    from wax.fanout.video_lane import VideoLane
    from wax.tape.recorder import Recorder
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_ASK_AGAIN_S: Final = 1.0
"""The least time between two requests for a keyframe, with which its file of a part begins."""


def format_of(settings: CameraSettings) -> CameraFormat:
    """Return what its pictures are like in the best rendition, which is recorded."""
    best = settings.renditions[0]
    return CameraFormat(settings.name, settings.codec, (best.width, best.height))


class CameraTrack:
    """Takes the best rendition of camera `number`; an error in it ends this track and no other.

    Parts begin with keyframes of the driving view, so this camera is asked for its own, which costs
    those who watch it once in a part.
    """

    def __init__(
        self, number: int, camera: Camera, recorder: Recorder, *, clock: Clock, counters: Counters
    ) -> None:
        self._number = number
        self._camera = camera
        self._recorder = recorder
        self._clock = clock
        self._boundary = ErrorBoundary(viewer=0, counters=counters, end=self._fail)
        self._lane: VideoLane | None = None
        self._asked_s = float("-inf")

    def start(self) -> None:
        """Begin, on the event loop."""
        self._lane = self._camera.hub.add(self._boundary)
        self._lane.listen(self._take)
        self._camera.hub.choose(self._lane, self._camera.settings.renditions[0].name)

    def leave(self) -> None:
        """Leave the fan-out; safe to call twice."""
        lane, self._lane = self._lane, None
        if lane is not None:
            self._camera.hub.remove(lane)

    def _take(self) -> None:
        while self._lane is not None and (picture := self._lane.take()):
            self._recorder.camera(self._number, picture)
        now_s = self._clock.now_s()
        waits = self._lane is not None and self._recorder.waits_for(self._number)
        if self._lane is not None and waits and now_s - self._asked_s >= _ASK_AGAIN_S:
            self._asked_s = now_s
            self._camera.hub.request_keyframe(self._lane)

    def _fail(self) -> None:
        _LOG.error(
            "a camera has failed on the tape; restart the server to record it again",
            camera=self._camera.name,
        )
        self.leave()
