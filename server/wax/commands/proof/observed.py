"""The driver of the server under proof: the host's own, with a log of its calls and reports.

It runs in the driver's process, which outlives the server. So it records when a stop arrived there,
and how long the robot moved on, even after the server is gone.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import time
from typing import TYPE_CHECKING, ClassVar, Final

from wax.config.driver_settings import DriverSettings
from wax.config.robot import RobotSettings
from wax.driver.checks import checked
from wax.robot.find_driver import make_driver

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.driver.interface import Driver, Limits, Pose, RobotState, Twist

_WATCH_S: Final = 0.5
"""How long the robot is watched once the process must end; closing a driver may take a second."""
_STOOD_S: Final = 0.2
_LOOK_S: Final = 0.01
_MOVED_M: Final = 0.0005
_TURNED_RAD: Final = 0.002
"""A turn by more than this counts as motion; less is noise."""


class ObservedSettings(DriverSettings):
    """Written by the proof, for one run."""

    TABLE: ClassVar[str] = "observed"

    robot: str
    """The host's own [robot], in JSON."""
    log: str
    """The file that gets a line for each call and report."""


class ObservedRobot:
    """A `Driver` that hands each call on. The lines of its log are `[at_s, what, moves, speed]`."""

    Settings = ObservedSettings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        own = settings.own(ObservedSettings)
        self._robot = RobotSettings.model_validate_json(own.robot)
        self._driver: Driver = make_driver(self._robot, clock)
        self._log = own.log
        self._file: int | None = None
        self._motion = ObservedMotion()
        self._moved_s = 0.0

    @property
    def kind(self) -> str:
        return self._driver.kind

    @property
    def limits(self) -> Limits:
        return self._driver.limits

    def open(self) -> None:
        if self._file is None:
            self._file = os.open(self._log, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
            self._write("opened")
        self._driver.open()

    def apply(self, twist: Twist, turn: int) -> None:
        self._driver.apply(twist, turn)
        aside_mps = abs(twist.angular_rps) * self._robot.lever_m
        self._write("said", not twist.is_zero, twist.speed_mps + aside_mps)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._driver.set_axis(name, position, turn)

    def stop(self, turn: int) -> None:
        self._driver.stop(turn)
        self._write("said", moves=False)

    def state(self) -> RobotState:
        state = checked(self._driver.state())
        if state.connected:
            moves = self._motion.seen(state)
            if moves:
                self._moved_s = time.monotonic()
            self._write("blind" if moves is None else "told", bool(moves))
        return state

    def close(self) -> None:
        """Watch the robot stand before it is released: nobody can see it after that."""
        if self._file is None:
            self._driver.close()
            return
        start_s = now_s = time.monotonic()
        while now_s < min(start_s + _WATCH_S, max(self._moved_s, start_s) + _STOOD_S):
            with contextlib.suppress(Exception):
                self.state()
            time.sleep(_LOOK_S)
            now_s = time.monotonic()
        self._driver.close()
        self._write("closed")
        os.close(self._file)
        self._file = None

    def _write(self, what: str, moves: bool = False, speed_mps: float = 0.0) -> None:
        if self._file is not None:
            speed = speed_mps if math.isfinite(speed_mps) else 0.0
            line = json.dumps([time.monotonic(), what, moves, speed])
            os.write(self._file, line.encode() + b"\n")


class ObservedMotion:
    """Whether a robot moves, by its own reports (pure): it says so, or its pose changes."""

    def __init__(self) -> None:
        self._pose: Pose | None = None

    def seen(self, state: RobotState) -> bool | None:
        """Return whether it moves, None if this state does not say."""
        if state.moving is not None:
            return state.moving
        if state.pose is None:
            return None
        before = self._pose
        if before is not None and not _differs(before, state.pose):
            return False
        self._pose = state.pose
        return before is not None


def _differs(before: Pose, now: Pose) -> bool:
    turned_rad = math.remainder(now.heading_rad - before.heading_rad, math.tau)
    moved_m = math.hypot(now.x_m - before.x_m, now.y_m - before.y_m)
    return moved_m > _MOVED_M or abs(turned_rad) > _TURNED_RAD
