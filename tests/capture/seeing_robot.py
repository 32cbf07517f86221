"""A robot with a camera and a microphone of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.idle_robot import IdleRobot

from wax.capture.testcard import TestCardAudio, TestCardVideo
from wax.config.audio import AudioSettings

if TYPE_CHECKING:
    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.video import VideoSettings


class SeeingRobot(IdleRobot):
    """A driver with a camera and a microphone."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return TestCardVideo(settings, clock)

    def microphone(self, clock: Clock) -> AudioSource:
        return TestCardAudio(AudioSettings(), clock)
