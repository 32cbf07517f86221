"""Passes a camera other than the driving view from the fan-out to the tape."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import structlog

from wax.error_boundary import ErrorBoundary
from wax.tape.camera_files import CameraFormat

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.camera import CameraSettings
    from wax.fanout.camera import Camera
    from wax.fanout.video_lane import VideoLane
    from wax.tape.recorder import Recorder
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_ASK_AGAIN_S: Final = 1.0
"""The least time between two requests for the keyframe that starts the camera's file."""


def format_of(settings: CameraSettings) -> CameraFormat:
    """Return the format of a camera's best rendition, which is recorded."""
    best = settings.renditions[0]
    return CameraFormat(settings.name, settings.codec, (best.width, best.height))


class CameraTrack:
    """Records the best rendition of camera `number`; an error in it ends only this track.

    Parts begin with keyframes of the driving view, so this camera needs a keyframe request, which
    its viewers pay for once in each part.
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
        """Join the fan-out; call it on the event loop."""
        self._lane = self._camera.hub.add(self._boundary)
        self._lane.set_listener(self._forward_pictures)
        self._camera.hub.choose(self._lane, self._camera.settings.renditions[0].name)

    def leave(self) -> None:
        """Leave the fan-out; safe to call twice."""
        lane, self._lane = self._lane, None
        if lane is not None:
            self._camera.hub.remove(lane)

    def _forward_pictures(self) -> None:
        while self._lane is not None and (picture := self._lane.pop_next()):
            self._recorder.camera(self._number, picture)
        now_s = self._clock.now_s()
        waits = self._lane is not None and self._recorder.needs_keyframe(self._number)
        if self._lane is not None and waits and now_s - self._asked_s >= _ASK_AGAIN_S:
            self._asked_s = now_s
            self._camera.hub.request_keyframe(self._lane)

    def _fail(self) -> None:
        _LOG.error(
            "a camera has failed on the tape; restart the server to record it again",
            camera=self._camera.name,
        )
        self.leave()
