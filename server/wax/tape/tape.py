"""Connects the tape to the server: its lanes in the fan-out and the recorder that they feed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import structlog

from wax.error_boundary import ErrorBoundary
from wax.sentence import Sentence
from wax.streams.rendition_ladder import sound_encodings
from wax.tape.camera_track import CameraTrack, format_of
from wax.tape.recorder import Format, Recorder
from wax.tape.repair import repair_beside
from wax.tape.shelf import Shelf, where

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.config.settings import Settings
    from wax.congestion.allocation import SoundEncoding
    from wax.fanout.camera import Camera
    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.sound_lane import BoundedSoundLane
    from wax.fanout.video_hub import VideoHub
    from wax.fanout.video_lane import VideoLane
    from wax.telemetry import Counters

_LOG = structlog.get_logger(__name__)

_FAILED: Final = Sentence("tape.given_up")
_SOUND_MS: Final = 20
"""The packet length of observers on good links; the nearest encoding is recorded."""


class TapeFeed:
    """Records the best rendition and one encoding of the sound, subscribed like another viewer.

    `video` is None for a robot without a camera, `audio` without a microphone; `cameras` are all
    others than the driving view. Raises `StateError` if no folder is configured.
    """

    def __init__(
        self,
        settings: Settings,
        *,
        clock: Clock,
        counters: Counters,
        video: VideoHub | None,
        audio: SoundHub | None,
        cameras: Sequence[Camera] = (),
    ) -> None:
        best = settings.video.renditions[0]
        self._rendition = best.name
        self._encodings = _encodings(settings)
        self._video = video
        self._audio = audio if settings.recording.sound else None
        self._boundary = ErrorBoundary(viewer=0, counters=counters, end=self._detach)
        self._picture_lane: VideoLane | None = None
        self._sound_lane: BoundedSoundLane | None = None
        recorded = cameras if settings.recording.cameras else ()
        self._folder = where(settings.recording, settings.server.state_dir)
        self.recorder = Recorder(
            Shelf(self._folder),
            settings=settings.recording,
            format=Format(
                codec=settings.video.codec,
                size=None if video is None else (best.width, best.height),
                has_sound=self.has_sound,
                sound_channels=self._encodings[0].channels,
                keyframe_interval_s=settings.video.keyframe_interval_s,
                cameras=tuple(format_of(one.settings) for one in recorded),
            ),
            clock=clock,
        )
        self._tracks = [
            CameraTrack(number, one, self.recorder, clock=clock, counters=counters)
            for number, one in enumerate(recorded, start=1)
        ]

    @property
    def has_sound(self) -> bool:
        """Whether the sound is recorded."""
        return self._audio is not None

    @property
    def has_cameras(self) -> bool:
        """Whether cameras other than the driving view are recorded."""
        return bool(self._tracks)

    def start(self) -> None:
        """Start recording; call it on the event loop."""
        repair_beside(self._folder)
        self.recorder.start()
        if self._video is not None:
            self._picture_lane = self._video.add(self._boundary)
            self._picture_lane.set_listener(self._forward_pictures)
            self._video.choose(self._picture_lane, self._rendition)
        if self._audio is not None:
            self._sound_lane = self._audio.add(self._boundary)
            self._sound_lane.set_listener(self._forward_sounds)
            self._choose_encoding(self._audio, self._sound_lane)
        for track in self._tracks:
            track.start()

    def request_stop(self) -> None:
        self.recorder.request_stop()

    def stop(self) -> None:
        """Finish the open part, in at most a second; safe to call twice."""
        self.recorder.stop()

    def _forward_pictures(self) -> None:
        while self._picture_lane is not None and (picture := self._picture_lane.pop_next()):
            self.recorder.picture(picture)

    def _forward_sounds(self) -> None:
        while self._sound_lane is not None and (sound := self._sound_lane.pop_next()):
            self.recorder.sound(sound)
        if self._audio is not None and self._sound_lane is not None:
            self._choose_encoding(self._audio, self._sound_lane)

    def _choose_encoding(self, audio: SoundHub, lane: BoundedSoundLane) -> None:
        """Choose stereo while the microphone has two working channels, else mono."""
        fitting = (encoding for encoding in self._encodings if encoding.channels <= audio.channels)
        audio.choose(lane, next(fitting, self._encodings[-1]), 0)

    def _detach(self) -> None:
        """Leave the fan-out after an error, so that the tape harms nobody else."""
        _LOG.error("the tape has failed; restart the server to record again")
        self.recorder.give_up(_FAILED)
        if self._video is not None and self._picture_lane is not None:
            self._video.remove(self._picture_lane)
        if self._audio is not None and self._sound_lane is not None:
            self._audio.remove(self._sound_lane)
        self._picture_lane = self._sound_lane = None
        for track in self._tracks:
            track.leave()


def _encodings(settings: Settings) -> list[SoundEncoding]:
    """Return the encoding to record, in stereo before mono."""
    nearest = min(settings.audio.encodings, key=lambda one: abs(one.mu_ms - _SOUND_MS))
    return sound_encodings(nearest, settings.audio.channels)
