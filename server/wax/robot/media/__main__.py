"""The media process: `python -m wax.robot.media`, started only by `MediaProcess`.

It builds the robot's driver but never opens it, and reads its camera and microphone. It ends only
when the pipe ends, however the server ended.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import threading
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import structlog

from wax.clock import SystemClock
from wax.config.camera import CameraSettings
from wax.config.video import DrivingViewSettings
from wax.errors import ConfigError, SourceError
from wax.machine import opencv
from wax.robot.build_driver import make_driver
from wax.robot.media.messages import MediaBegin
from wax.robot.media.outlets import CameraOutlet, MicrophoneOutlet, SpeakerOutlet
from wax.robot.media.picture_memory import PictureMemory
from wax.robot.process.child_start import (
    READ_BYTES,
    claim_pipes,
    first_line,
    log_as,
    outlive_signals,
    run,
)
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.robot.media.messages import Outlet as OutletSettings
    from wax.robot.media.outlets import SenseOutlet

_LOG = structlog.get_logger(__name__)

BEAT_S: Final = 0.5
_END_S: Final = 1.5


def main() -> int:
    """Serve one robot's senses until the pipe ends."""
    outlive_signals()
    # If memory runs out, the system should kill this process before the server and the driver.
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500", encoding="ascii")
    reader, writer = claim_pipes()
    line = first_line(reader)
    if line is None:
        return 0
    begin = MediaBegin.model_validate_json(line)
    log_as(begin.log, "the robot's camera")
    opencv.keep_in_one_thread()
    clock = SystemClock()
    robot = _Robot(begin, clock)
    outlets = [_outlet(one, robot, clock) for one in begin.outlets]
    for outlet in outlets:
        outlet.start()
    os.set_blocking(writer, False)
    while True:
        with contextlib.suppress(BlockingIOError):
            os.write(writer, b"\n")
        if select.select([reader], [], [], BEAT_S)[0] and not os.read(reader, READ_BYTES):
            break
    # An alarm ends the process even if a plug-in hangs while holding the GIL.
    signal.setitimer(signal.ITIMER_REAL, _END_S)
    for outlet in outlets:
        outlet.request_stop()
    for outlet in outlets:
        outlet.stop()
    return 0


class _Robot:
    """The driver, built by the first sense that is opened."""

    def __init__(self, begin: MediaBegin, clock: Clock) -> None:
        self._begin = begin
        self._clock = clock
        self._lock = threading.Lock()
        self._driver: Any = None

    def sense(self, outlet: OutletSettings) -> Any:
        """Make one of its senses; raises whatever the driver raises."""
        make = getattr(self._built(), outlet.sense)
        if outlet.sense == "camera":
            return make(DrivingViewSettings.model_validate(outlet.video), self._clock)
        if outlet.sense == "external_view":
            return make(CameraSettings.model_validate(outlet.video), self._clock)
        return make(self._clock)

    def _built(self) -> Any:
        with self._lock:
            if self._driver is None:
                try:
                    self._driver = make_driver(self._begin.robot, self._clock)
                except ConfigError as error:
                    raise SourceError(
                        Sentence("robot.driver_not_built", {"why": str(error)})
                    ) from error
            return self._driver


def _outlet(one: OutletSettings, robot: _Robot, clock: Clock) -> SenseOutlet:
    os.set_inheritable(one.connection, False)
    connection = Connection(one.connection)
    if one.sense == "speaker":
        return SpeakerOutlet(lambda: robot.sense(one), connection)
    if one.sense == "microphone":
        return MicrophoneOutlet(lambda: robot.sense(one), connection, clock=clock)
    assert one.memory is not None
    assert one.video is not None
    memory = PictureMemory(one.memory)
    os.close(one.memory)
    return CameraOutlet(
        lambda: robot.sense(one),
        connection,
        memory,
        name="camera",
        clock=clock,
    )


if __name__ == "__main__":
    run(main, "the media process")
