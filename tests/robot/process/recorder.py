"""A third-party driver that logs its calls; it can run in any process."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING

from tests.idle_robot import IdleRobot

from wax.driver.hand import HandReading
from wax.driver.interface import Limits, RobotState

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import ControlValue, Twist


class Recorder(IdleRobot):
    """Appends a line for each call to the file that is configured as its port."""

    kind = "recorder"
    limits = Limits(0.6, 1.5, axes=("pan",), ttl_s=0.2, lateral_mps=0.6)

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self._path = Path(settings.serial.url)
        self._epoch = 0

    def open(self) -> None:
        self._epoch += 1
        print("what a driver prints is nobody's message")  # noqa: T201
        self._write("open", os.getpid())

    def apply(self, twist: Twist, turn: int) -> None:
        self._write("apply", twist.linear_mps, twist.angular_rps, twist.lateral_mps, turn)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._write("axis", position, turn)

    def stop(self, turn: int) -> None:
        self._write("stop", turn)

    def close(self) -> None:
        self._write("close")

    def state(self) -> RobotState:
        return RobotState(connected=self._epoch > 0, epoch=self._epoch, extra={"battery_v": 7.4})

    def _write(self, word: str, *values: float) -> None:
        line = " ".join([f"{time.monotonic():.6f}", word, *map(str, values)])
        with self._path.open("a") as file:
            file.write(line + "\n")


class Seated(Recorder):
    """Has a person aboard, who follows a second file with two numbers and a button."""

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        super().__init__(settings, clock)
        self._clock = clock

    def hand(self) -> HandReading | None:
        path = self._path.with_suffix(".hand")
        if not path.exists():
            return None
        linear, angular, button = path.read_text().split()
        return HandReading(
            self._clock.now_s(),
            float(linear),
            float(angular),
            stop=button == "stop",
            ask="go_on" if button == "go_on" else None,
        )


class Equipped(Recorder):
    """Has a horn, and a control that moves."""

    limits = Limits(0.6, 1.5, ttl_s=0.2, controls=("horn", "spin"))

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        self._write(name, float(value is True), turn)


class Fragile(Recorder):
    """Raises when asked to turn."""

    def apply(self, twist: Twist, turn: int) -> None:
        if twist.angular_rps != 0.0:
            raise OSError("no bus")
        super().apply(twist, turn)


class Liar(Recorder):
    """Returns an invalid state."""

    def state(self) -> RobotState:
        extra: dict[str, float] = {"battery_v": None}  # type: ignore[dict-item]
        return RobotState(connected=True, extra=extra)


class Stuck(Recorder):
    """Hangs in `close`."""

    def close(self) -> None:
        super().close()
        time.sleep(30.0)
