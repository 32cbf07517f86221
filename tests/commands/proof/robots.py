"""A host's own robots, which a configuration names as ``tests.commands.proof.robots:Class``."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Final

from pydantic import Field

from wax.config.driver_settings import DriverSettings
from wax.driver.interface import STANDSTILL, Pose
from wax.robot.steady import Reading, SteadyRobot

if TYPE_CHECKING:
    from wax.driver.interface import Twist


LEFT: Final = "ROBOT_IS_LEFT"
"""The variable that names a file for how each robot was left."""


class WheelSettings(DriverSettings):
    TABLE: ClassVar[str] = "wheels"

    bus: Annotated[int, Field(ge=0, le=7)] = Field(1, description="The number of their bus.")


class Moving(SteadyRobot):
    """Reports motion from a set-point until `brakes_s` after its end."""

    Settings = WheelSettings
    brakes_s: ClassVar[float] = 0.05

    def connect(self) -> None:
        self._twist = STANDSTILL
        self._moved_s = 0.0
        self._asked_s = time.monotonic()
        self._way_m = 0.0

    def tell(self, twist: Twist) -> Reading | None:
        now_s = time.monotonic()
        if self.moves(now_s):
            self._way_m += (now_s - self._asked_s) * 0.2
        self._asked_s = now_s
        self._twist = twist
        if not twist.is_zero:
            self._moved_s = now_s
        return self.reading(now_s)

    def disconnect(self) -> None:
        """Write down whether it still moves."""
        left = os.environ.get(LEFT)
        if left is not None:
            with Path(left).open("a", encoding="utf-8") as file:
                file.write("standing\n" if self._twist.is_zero else "moving\n")

    def moves(self, now_s: float) -> bool:
        return not self._twist.is_zero or now_s - self._moved_s < self.brakes_s

    def reading(self, now_s: float) -> Reading | None:
        return Reading(moving=self.moves(now_s))


class Sliding(Moving):
    """Moves sideways, too, and writes down when it did."""

    moves_sideways: ClassVar[bool] = True
    slid = False

    def tell(self, twist: Twist) -> Reading | None:
        self.slid = self.slid or twist.lateral_mps > 0.0
        return super().tell(twist)

    def disconnect(self) -> None:
        super().disconnect()
        with Path(os.environ[LEFT]).open("a", encoding="utf-8") as file:
            file.write("slid\n" if self.slid else "")


class Posing(Moving):
    """Reports only its pose."""

    def reading(self, now_s: float) -> Reading | None:
        return Reading(pose=Pose(self._way_m, 0.0, 0.0))


class Late(Moving):
    """Rolls on for a second after a stop."""

    brakes_s = 1.0


class Blind(Moving):
    """Drives, and reports nothing."""

    def reading(self, now_s: float) -> Reading | None:
        return None


class Absent(Moving):
    """Cannot be reached."""

    def connect(self) -> None:
        raise OSError("no route to it")
