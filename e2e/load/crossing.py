"""What it costs that a robot's camera is in a process of its own: age and CPU of a picture."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.load.process import ProcessMeter
from e2e.load.servers import WAX
from e2e.load.steady_camera import DRIVER, SteadyRobot
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from wax.capture.source_thread import SourceThread
from wax.clock import SystemClock
from wax.config.settings import RobotSettings, VideoSettings
from wax.driver.interface import HasCamera
from wax.robot.find_driver import make_robot

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.capture.source import Picture
    from wax.driver.interface import Driver

SIZES: Final = ((640, 480), (1280, 720))
_SETTLE: Final = 30
_AGE_MS: Final = 3.0
_CPU_MS: Final = 1.0
_PATIENCE_S: Final = 20.0
_ROUNDS: Final = 5


@dataclass(frozen=True, slots=True)
class Watch:
    """The ages of the pictures when they were there, and the CPU time of one, in ms."""

    ages_ms: list[float]
    cpu_ms: list[float]


def crossing(n: int) -> list[Row]:
    """Watch `n` pictures of each size in each place, in rounds by turns."""
    rows: list[Row] = []
    for size in SIZES:
        inside, across = Watch([], []), Watch([], [])
        for _ in range(_ROUNDS):
            for watch, is_inside in ((inside, True), (across, False)):
                seen = _watched(size, max(1, n // _ROUNDS), is_inside=is_inside)
                watch.ages_ms.extend(seen.ages_ms)
                watch.cpu_ms.extend(seen.cpu_ms)
        rows += rows_of(size, inside, across)
    return rows


def rows_of(size: tuple[int, int], inside: Watch, across: Watch) -> list[Row]:
    """Compare the two places."""
    name = f"{size[0]}×{size[1]}"
    ages = summarize(inside.ages_ms), summarize(across.ages_ms)
    cpu = summarize(inside.cpu_ms), summarize(across.cpu_ms)
    n = len(across.ages_ms)
    return [
        judged(
            f"crossing: age {name}",
            f"a robot's own camera at {name} from its process: age added to a picture, p99",
            "ms",
            {WAX: ages[1].p99 - ages[0].p99},
            _AGE_MS,
            n=n,
            detail={"inside": str(ages[0]), "across": str(ages[1])},
        ),
        judged(
            f"crossing: cpu {name}",
            "… CPU added for a picture, of both processes",
            "ms",
            {WAX: cpu[1].median - cpu[0].median},
            _CPU_MS,
            n=n,
            detail={"inside": str(cpu[0]), "across": str(cpu[1])},
        ),
    ]


def _watched(size: tuple[int, int], n: int, *, is_inside: bool) -> Watch:
    clock = SystemClock()
    settings = RobotSettings(driver=DRIVER)
    robot: Driver = SteadyRobot(settings, clock) if is_inside else make_robot(settings, clock)
    assert isinstance(robot, HasCamera)
    meter = ProcessMeter(os.getpid())
    ages_ms: list[float] = []

    def see(picture: Picture) -> None:
        ages_ms.append((clock.now_s() - picture.captured_s) * 1000)

    source = robot.camera(VideoSettings(width=size[0], height=size[1], fps=30), clock)
    thread = SourceThread(source, see, name="camera", clock=clock, retry_s=0.1)
    thread.start()
    try:
        _wait(ages_ms, _SETTLE)
        began, before_s = len(ages_ms), meter.cpu_s()
        _wait(ages_ms, began + n)
        used_s, ended = meter.cpu_s() - before_s, len(ages_ms)
    finally:
        thread.stop()
        robot.close()
    return Watch(ages_ms[began:ended], [used_s * 1000 / (ended - began)])


def _wait(seen: Sequence[float], count: int) -> None:
    """Sleep until so many were seen; looking costs nearly nothing."""
    end_s = time.monotonic() + _PATIENCE_S + count / 20
    while len(seen) < count:
        if time.monotonic() > end_s:
            raise MeasureError(f"{len(seen)} of {count} pictures came")
        time.sleep(0.2)
