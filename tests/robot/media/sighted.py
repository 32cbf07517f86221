"""Third-party drivers with cameras, a microphone and a speaker, for any process."""

from __future__ import annotations

import os
import signal
import time
from typing import TYPE_CHECKING

import numpy as np
from tests.robot.process.recorder import Recorder

from wax.capture.source import BLOCK_SAMPLES, Picture, Sound
from wax.driver.interface import OwnView
from wax.errors import SourceError, SpeakerError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from wax.capture.source import AudioSource, VideoSource
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.video import VideoSettings
    from wax.speaker.interface import Speaker


class Eye:
    """Each picture is filled with a number that counts up, modulo 250."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._settings = settings
        self._clock = clock
        self._number = 0

    def open(self) -> None:
        if not self._settings.width:
            raise SourceError("no width")

    def read(self) -> Picture:
        time.sleep(1.0 / self._settings.fps)
        self._number = (self._number + 1) % 250
        shape = (self._settings.height * 3 // 2, self._settings.width)
        return Picture(np.full(shape, self._number, np.uint8), self._clock.now_s(), within_s=0.05)

    def close(self) -> None: ...


class Ear:
    """Fills each block with a number that counts up, negated on the right."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._number = 0

    def open(self) -> None: ...

    def read(self) -> Sound:
        time.sleep(0.01)
        self._number += 1
        left = np.full(BLOCK_SAMPLES, self._number, np.int16)
        return Sound(np.column_stack((left, -left)), self._clock.now_s())

    def close(self) -> None: ...


class Mouth:
    """Logs each block; refuses the number 13, and hangs at 99."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def open(self) -> None:
        self._path.write_text("")

    def write(self, samples: NDArray[np.int16]) -> None:
        if samples[0] == 13:
            raise SpeakerError("an unlucky number")
        if samples[0] == 99:
            time.sleep(30.0)
        with self._path.open("a") as file:
            file.write(f"{len(samples)} {samples[0]}\n")

    def close(self) -> None: ...


class Sighted(Recorder):
    """A driver with cameras, a microphone and a speaker."""

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        super().__init__(settings, clock)
        self._clock = clock

    @property
    def own_view(self) -> OwnView:
        return OwnView(0.3, 10.0, 60.0, 0.4)

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return Eye(settings, clock)

    def external_view(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return Eye(settings, clock)

    def microphone(self, clock: Clock) -> AudioSource:
        return Ear(clock)

    def speaker(self, clock: Clock) -> Speaker:
        return Mouth(self._path.with_suffix(".said"))


class Wilful(Sighted):
    """Its camera misbehaves as a file next to the driver's log says."""

    def camera(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return _WilfulEye(settings, clock, self._path.with_suffix(".will"))


class _WilfulEye(Eye):
    def __init__(self, settings: VideoSettings, clock: Clock, path: Path) -> None:
        super().__init__(settings, clock)
        self._path = path

    def read(self) -> Picture:
        picture = super().read()
        will = self._path.read_text() if self._path.exists() else ""
        if will == "raise":
            raise OSError("no lens")
        if will == "hang":
            time.sleep(30.0)
        if will == "exit":
            os._exit(3)
        if will == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if will == "odd":
            return Picture(picture.i420[:-1], picture.captured_s)
        if will == "large":
            return Picture(np.zeros((4096 * 3 // 2, 4096), np.uint8), picture.captured_s)
        if will == "none":
            return None  # type: ignore[return-value]
        return picture
