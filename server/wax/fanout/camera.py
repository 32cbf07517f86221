"""An additional camera: its source, and the encoders that run while somebody watches it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.capture.source_thread import SourceThread
from wax.capture.timestamp_overlay import TimestampOverlay
from wax.fanout.video_hub import VideoHub
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Picture, VideoSource
    from wax.clock import Clock
    from wax.config.camera import CameraSettings
    from wax.config.video import RenditionSettings
    from wax.encode.video_encoder import PictureEncoder


class Camera:
    """The camera of one `[[camera]]` table; `blank` replaces or drops pictures in its thread."""

    def __init__(
        self,
        settings: CameraSettings,
        source: VideoSource,
        *,
        clock: Clock,
        blank: Callable[[Picture], Picture | None],
        make_encoder: Callable[[RenditionSettings], PictureEncoder] | None = None,
    ) -> None:
        self.settings = settings
        self.hub = VideoHub(settings=settings, clock=clock, make_encoder=make_encoder)
        put: Callable[[Picture], None] = self.hub.slot.put
        if settings.timestamp_overlay:
            put = TimestampOverlay(clock, put)
        self._put = put
        self._blank = blank
        self._capture = SourceThread(
            source,
            self._take,
            name=f"camera {settings.name}",
            clock=clock,
            needed=self.hub.slot.needed,
        )

    @property
    def name(self) -> str:
        return self.settings.name

    @property
    def problem(self) -> Sentence | None:
        """Why the camera delivers nothing, in a sentence that names it, else None."""
        problem = self._capture.problem
        if problem is None or self.name in str(problem):
            return problem
        return Sentence("camera.named", {"name": self.name, "problem": problem})

    @property
    def failures(self) -> int:
        """How often the source has failed since the start."""
        return self._capture.failures

    def start(self) -> None:
        self.hub.start()
        self._capture.start()

    def request_stop(self) -> None:
        """Ask all threads to end, and return at once; `stop` then waits for them."""
        self._capture.request_stop()
        self.hub.request_stop()

    def stop(self) -> None:
        """End all threads; bounded, safe to call twice."""
        self._capture.stop()
        self.hub.stop()

    def _take(self, picture: Picture) -> None:
        shown = self._blank(picture)
        if shown is not None:
            self._put(shown)
