"""From the sources to the hubs whose lanes serve the viewers.

picture: source → capture → slot → rendition → lane → track → browser
sound:   source → capture → blocks → encoder → lane → track → browser
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import structlog

from wax.baseline.streams import BaselineService, thesis_video
from wax.baseline.unit_hub import UnitHub
from wax.capture import find_sources
from wax.capture.audio_blocks import Blocks
from wax.capture.blanking import Blanking
from wax.capture.channel_faults import ChannelFaults
from wax.capture.source_thread import SourceThread
from wax.capture.timestamp_overlay import TimestampOverlay
from wax.cluster.cluster import PublishedSources
from wax.cluster.room_directory import published, upload_left_bps
from wax.control.driving_view import DrivingView
from wax.encode.video_encoder import IntraEncoder
from wax.fanout.camera import Camera
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.streams.live import LiveService

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Picture, Sound
    from wax.clock import Clock
    from wax.cluster.cluster import Cluster
    from wax.driver.interface import Driver
    from wax.encode.auto_size import Prepared
    from wax.streams.interface import Service

_LOG = structlog.get_logger(__name__)


class Pipelines:
    """The sources, encoders and hubs; while `is_blanked`, a card replaces what they deliver."""

    audio: SoundHub | UnitHub
    service: Service

    def __init__(
        self, prepared: Prepared, clock: Clock, driver: Driver, is_blanked: Callable[[], bool]
    ) -> None:
        self._settings = settings = prepared.settings
        self._clock = clock
        self._published = published(settings.video.renditions, prepared.rooms_bps)
        self._blanking = Blanking(is_blanked)
        self.encoders = prepared.encoders
        self.cameras = [
            Camera(
                one,
                find_sources.make_camera(one, clock, driver),
                clock=clock,
                blank=Blanking(is_blanked).picture,
                make_encoder=makers.make,
            )
            for one, makers in zip(settings.camera, self.encoders[1:], strict=True)
        ]
        if settings.sync.policy == "thesis":
            self._make_thesis_service()
        else:
            self._make_live_service()
        self.view, self.blocks = DrivingView(), Blocks()
        self.captures = self._make_captures(driver)
        self.channel_faults = ChannelFaults(_log_channel_fault, most=settings.audio.channels)

    def publish(self, cluster: Cluster) -> None:
        """Have the LiveKit rooms fed with the driving view; none under the thesis policy."""
        if isinstance(self.audio, SoundHub):
            sound = self.audio if self._settings.access.strangers_hear else None
            cluster.publish(
                self._settings.publish,
                [one.name for one in self._published],
                PublishedSources(self.service.codecs, self.video, sound),
            )

    def start(self) -> None:
        self.video.start()
        self.audio.start()
        for capture in (*self.captures.values(), *self.cameras):
            capture.start()

    @property
    def threads(
        self,
    ) -> tuple[SourceThread[Picture] | SourceThread[Sound] | Camera | VideoHub, ...]:
        """What has to be stopped at the end."""
        return (*self.captures.values(), *self.cameras, self.video)

    def _make_thesis_service(self) -> None:
        thesis = self._settings.thesis
        video = thesis_video(self._settings.video, thesis)
        self.video = VideoHub(settings=video, clock=self._clock, make_encoder=IntraEncoder)
        self.audio = UnitHub(mu_ms=thesis.audio_mu_ms)
        self.service = BaselineService(
            clock=self._clock, settings=thesis, video=self.video, audio=self.audio
        )

    def _make_live_service(self) -> None:
        settings, clock, make = self._settings, self._clock, self.encoders[0].make
        self.video = VideoHub(settings=settings.video, clock=clock, make_encoder=make)
        self.audio = SoundHub(clock)
        self.service = LiveService(
            clock=clock,
            video_settings=settings.video,
            audio_settings=settings.audio,
            video=self.video,
            audio=self.audio,
            upload_bps=upload_left_bps(
                settings.network.upload_bps, self._published, settings.publish
            ),
            cameras=self.cameras,
        )

    def _make_captures(
        self, driver: Driver
    ) -> dict[str, SourceThread[Picture] | SourceThread[Sound]]:
        video, audio = self._settings.video, self._settings.audio
        cameras = self._settings.camera
        find_sources.warn_of_shared_addresses(video.source, audio.source, cameras)
        taken = [one.source for one in cameras]
        sources = find_sources.make_sources(video, audio, self._clock, driver, taken)
        captures: dict[str, SourceThread[Picture] | SourceThread[Sound]] = {}
        if sources.video is not None:
            captures["video"] = self.view.camera = SourceThread(
                sources.video,
                self._picture_handler(),
                name="camera",
                clock=self._clock,
                needed=self.video.slot.needed,
            )
        if sources.audio is not None:
            captures["audio"] = SourceThread(
                sources.audio,
                self._handle_sound,
                name="microphone",
                clock=self._clock,
                needed=self.audio.needed,
            )
        return captures

    def _picture_handler(self) -> Callable[[Picture], None]:
        """Return the function that handles pictures in the camera's thread."""
        put: Callable[[Picture], None] = self.video.slot.put
        if self._settings.video.timestamp_overlay:
            put = TimestampOverlay(self._clock, put)

        def handle(picture: Picture) -> None:
            self.view.captured(picture.captured_s, picture.within_s)
            shown = self._blanking.picture(picture)
            if shown is not None:
                put(shown)

        return handle

    def _handle_sound(self, sound: Sound) -> None:
        """Handle sound, in the microphone's thread."""
        heard = self.channel_faults.push(self._blanking.sound(sound))
        if not self.audio.needed.is_set():
            self.blocks.restart()
            self.audio.skip(heard)
            return
        for block in self.blocks.push(heard):
            self.audio.push(block)


def _log_channel_fault(problem: str | None) -> None:
    if problem is None:
        _LOG.info("both channels of the microphone are back")
    else:
        _LOG.warning("one channel of the microphone has failed", problem=problem)
